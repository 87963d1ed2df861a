#!/usr/bin/env bash
# Install what is missing, build, and run every test. See manual/testing.md.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")" || exit 1
source tools/setup.sh

usage() {
  cat <<'TEXT'
usage: ./test.sh [--quick | --unit | --long] [--help]

Installs missing Debian packages, builds the release and debug presets, and runs
  unit tests       tests/unit/*.pf, in both builds
  scene tests      tests/test_*.py and tests/scenes/, with the release build; those marked fast with the debug build too
  style checks     formatting, spelling, and the project's own rules (tests/style.py)
The last line sums up: N passed, N failed. The exit status is 0 when nothing failed.

  --quick   release build only: unit tests, fast scenes, style checks
  --unit    unit tests only, in both builds
  --long    also the scenes marked long (many minutes)

Environment: PYTHON names the Python to use; CI=true makes missing style tools a failure.
TEXT
}

quick=false unit_only=false long=false
for argument in "$@"; do
  case $argument in
    --quick) quick=true ;;
    --unit) unit_only=true ;;
    --long) long=true ;;
    --help | -h) usage; exit 0 ;;
    *) usage >&2; printf "error: unknown option '%s'\n" "$argument" >&2; exit 2 ;;
  esac
done

passed=0 failed=0 summary=()

# run_part NAME COMMAND...: run, time and count one part. The command's last 'N passed, N failed' line is its result;
# a command that ends badly without a failure counted, or prints no such line, is one failure.
run_part() {
  local name=$1 log status=0 line part_passed=0 part_failed=0 start=$SECONDS
  shift
  log=$(mktemp)
  say "== $name"
  "$@" 2>&1 | tee "$log" || status=$?
  line=$(grep -E '[0-9]+ passed, [0-9]+ failed' "$log" | tail -n 1)
  rm -f "$log"
  if [[ $line =~ ([0-9]+)\ passed,\ ([0-9]+)\ failed ]]; then
    part_passed=${BASH_REMATCH[1]}
    part_failed=${BASH_REMATCH[2]}
  else
    part_failed=1
  fi
  ((status != 0 && part_failed == 0)) && part_failed=1
  passed=$((passed + part_passed))
  failed=$((failed + part_failed))
  summary+=("$(printf '%-26s %5d passed %4d failed %6d s' "$name" "$part_passed" "$part_failed" $((SECONDS - start)))")
  say ""
  ((part_failed == 0))
}

build() { build_preset "$1" "$2" && say "$1 build in $2: 1 passed, 0 failed"; }

unit_tests() {
  local directory=$1 report=$PWD/$1/unit.xml status=0
  ctest --test-dir "$directory" -L unit --parallel "$jobs" --quiet --output-junit "$report" \
    --test-output-size-passed 1000000 --test-output-size-failed 1000000 || status=$?
  "$PYTHON" tests/count_results.py --show "$report" && return "$status"
}

scene_tests() {
  local directory=$1 report=$PWD/$1/scenes.xml status=0
  shift
  "$PYTHON" -m pytest tests -q -n "$jobs" --dist loadgroup --build "$directory" --junitxml "$report" --durations 5 "$@" ||
    status=$?
  ((status == 5)) && status=0 # pytest's word for "none of the tests is marked so"
  "$PYTHON" tests/count_results.py "$report" && return "$status"
}

# fprettify and ruff are not in Debian: a small environment under build/, made once for each list of versions.
style_tools() {
  local environment=$PWD/$release_directory/.venv wanted=tools/style-requirements.txt
  cmp -s "$wanted" "$environment/installed.txt" && return
  say "Installing the style tools into $environment"
  "$PYTHON" -m venv "$environment" &&
    "$environment/bin/python" -m pip install -q --timeout 30 --retries 1 -r "$wanted" &&
    cp "$wanted" "$environment/installed.txt"
}

style_checks() {
  local tools=()
  style_tools && tools=(--tools "$release_directory/.venv/bin")
  "$PYTHON" tests/style.py "${tools[@]}"
}

install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}"
choose_python

run_part "build, release" build release "$release_directory" && release_built=true || release_built=false
$release_built && run_part "unit tests, release" unit_tests "$release_directory"
if ! $quick; then
  run_part "build, debug" build debug "$debug_directory" && debug_built=true || debug_built=false
  $debug_built && run_part "unit tests, debug" unit_tests "$debug_directory"
fi
if ! $unit_only; then
  scene_choice=()
  $quick && scene_choice=(-m "fast or tools")
  $long && scene_choice=(--long)
  $release_built && run_part "scene tests, release" scene_tests "$release_directory" "${scene_choice[@]}"
  ! $quick && $debug_built && run_part "scene tests, debug" scene_tests "$debug_directory" -m fast
  run_part "style checks" style_checks
fi

printf '%s\n' "${summary[@]}"
printf 'in %d s\n' "$SECONDS"
printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0 && passed > 0))
