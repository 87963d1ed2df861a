#!/usr/bin/env bash
# Install what is missing, build, run a deck and draw its figure. See manual/installing.md.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
default_deck=$here/input/direct_shear/shear_6cm.nml

usage() {
  cat <<'TEXT'
usage: ./run.sh [DECK.nml] [--help]

Installs missing Debian packages, builds the program (build/femdem), then for the deck
  1. makes its mesh, unless it is there and was made by the same command from the same files: the mesh script, the modules
     beside it and the files in its arguments. How is said by a comment line of the deck, a Python script beside the
     deck with its arguments:
         ! mesh: make_mesh.py --length 0.06 --out shear_6cm.msh
     or a command of the Python package, femdem-mesh or femdem-traces; several such lines are done in order:
         ! mesh: femdem-mesh traces.csv --size 0.02 --out traces.msh
  2. runs it; the results go to results/<scene>/<deck>/ where <scene> is the name of the deck's folder
  3. draws its figures into figures/ there and prints their tables of errors, as comment lines of the deck say,
     a figure of femdem-plot with its arguments each:
         ! figure: shear --length 0.06

Without a deck it runs the direct shear test of the paper, input/direct_shear/shear_6cm.nml.
Environment: PYTHON names the Python to use.
TEXT
}

deck=$default_deck
case ${1:-} in
  --help | -h) usage; exit 0 ;;
  -*) usage >&2; printf "error: unknown option '%s'\n" "$1" >&2; exit 2 ;;
  ?*) deck=$1 ;;
esac
(($# <= 1)) || { usage >&2; printf 'error: one deck at a time\n' >&2; exit 2; }
[[ -f $deck ]] || { printf "error: there is no deck '%s'\n" "$deck" >&2; exit 2; }

deck=$(realpath "$deck")
folder=$(dirname "$deck")
scene=$(basename "$folder")
cd "$here"
source tools/setup.sh
results=$here/results/$scene/$(basename "$deck" .nml)

install_packages "${build_packages[@]}" "${run_packages[@]}"
choose_python
if built "$release_directory"; then
  say "The program is built from these sources: $release_directory/femdem"
else
  say "Building the program (the first time takes a minute or two)"
  build_preset release "$release_directory" || exit 1
fi

# The mesh file a deck names (mesh = 'file.msh' in its &run group) and the commands that make it, the last of them the mesh itself.
mesh=$(sed -nE "s/^[^!]*\bmesh *= *['\"]([^'\"]+)['\"].*/\1/Ip" "$deck" | head -n 1)
mapfile -t mesh_lines < <(sed -nE 's/^ *! *mesh: *(.+)$/\1/p' "$deck")
for line in "${mesh_lines[@]}"; do
  [[ -n $mesh ]] || give_up "the deck has a line '! mesh: ...' but no mesh = 'FILE' in &run on a line of its own"
  say "Mesh: $line"
  read -ra mesh_command <<<"$line"
  product=$mesh
  [[ $line != "${mesh_lines[-1]}" ]] && product=$(sed -nE 's/.*--out +([^ ]+).*/\1/p' <<<"$line")
  case ${mesh_command[0]} in
    femdem-mesh) mesh_command=(-m femdem.network.make_mesh "${mesh_command[@]:1}") ;;
    femdem-traces) mesh_command=(-m femdem.network.make_traces "${mesh_command[@]:1}") ;;
  esac
  (cd "$folder" && "$PYTHON" -m femdem.kept "$product" "$PYTHON" "${mesh_command[@]}")
done
if ((${#mesh_lines[@]} == 0)) && [[ -n $mesh && ! -f $folder/$mesh ]]; then
  give_up "the mesh $folder/$mesh is missing, and the deck has no line '! mesh: SCRIPT ...' that says how to make it"
fi

say "Running $deck"
"$release_directory/femdem" --output "$results" "$deck"

figures=()
while read -ra figure_command; do
  say "Figure: ${figure_command[*]}"
  output=$("$PYTHON" -m femdem plot "${figure_command[0]}" "$results" "${figure_command[@]:1}")
  say "$output"
  while read -r line; do
    [[ $line == *.png ]] && figures+=("$line")
  done <<<"$output"
done < <(sed -nE 's/^ *! *figure: *(.+)$/\1/p' "$deck")
((${#figures[@]})) || say "The deck has no line '! figure: NAME ...'; bin/femdem-plot --help lists the figures"

say "Results: $results"
if ((${#figures[@]})) && [[ -n ${DISPLAY:-}${WAYLAND_DISPLAY:-} ]] && command -v xdg-open >/dev/null; then
  (xdg-open "${figures[0]}" >/dev/null 2>&1 &)
fi
