# Shared by run.sh and test.sh (sourced, from the repository's top): packages, Python, build.
# shellcheck shell=bash disable=SC2034

# A compiler without recommended packages lacks make and the C library's headers: name them.
build_packages=(gcc libc6-dev make gfortran cmake pkg-config git
  libhdf5-dev libmetis-dev libopenblas-dev libmumps-seq-dev libsuitesparse-dev)
run_packages=(gmsh python3-gmsh python3-numpy python3-h5py python3-matplotlib python3-scipy python3-shapely)
test_packages=(python3-pytest python3-pytest-xdist python3-venv codespell)

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# Looked for, not imported: importing all of them takes a second
has_modules="import sys, importlib.util as u; sys.exit(not all(map(u.find_spec, 'numpy h5py matplotlib gmsh'.split())))"
release_directory=build
debug_directory=build-debug
jobs=$(nproc 2>/dev/null || echo 2)

say() { printf '%s\n' "$*"; }

give_up() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}

# Install those of the named Debian packages that are missing.
install_packages() {
  local package missing=()
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    say "No apt-get here: please provide yourself: $*"
    return
  fi
  for package in "$@"; do
    [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  local as_root=()
  if [[ $(id -u) -ne 0 ]]; then
    command -v sudo >/dev/null || give_up "these packages are missing, and installing them needs root or sudo:
  apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  say "Installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq || say "warning: apt-get update failed; trying with the lists at hand"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" \
    >/dev/null || give_up "apt-get could not install: ${missing[*]}"
}

# Set PYTHON to the first Python that has what the package in postproc/ imports ($PYTHON, Debian's own, the first in PATH), and
# let it find the package.
choose_python() {
  local candidate
  export PYTHONPATH=$top/postproc${PYTHONPATH:+:$PYTHONPATH}
  for candidate in "${PYTHON:-}" /usr/bin/python3 python3; do
    [[ -n $candidate ]] || continue
    if "$candidate" -c "$has_modules" >/dev/null 2>&1; then
      PYTHON=$candidate
      export PYTHON
      return
    fi
  done
  give_up "no Python can import numpy, h5py, matplotlib and gmsh; name one with PYTHON=/path/to/python3"
}

# Is the program in a build directory newer than all that it is made from, and of the commit that is checked out? Asking CMake takes
# longer than a short run.
built() {
  local program=$1/femdem log
  [[ -x $program && $program -nt $1/CMakeCache.txt ]] || return 1
  log=$(git rev-parse --git-path logs/HEAD 2>/dev/null) && [[ $log -nt $program ]] && return 1
  [[ -z $(find CMakeLists.txt CMakePresets.json cmake modules src -newer "$program" -print -quit) ]]
}

# Configure and build a preset (release or debug); the full output goes to a log, its end to the screen on failure.
build_preset() {
  local preset=$1 directory=$2
  local made_for=""
  [[ -f $directory/CMakeCache.txt ]] && made_for=$(sed -n 's/^CMAKE_HOME_DIRECTORY:[^=]*=//p' "$directory/CMakeCache.txt")
  if [[ -n $made_for && ! $made_for -ef $top ]]; then
    say "error: $directory was made for the project in $made_for, not for $top (was it moved or copied?)
  remove $directory and try again:  rm -r $directory"
    return 1
  fi
  mkdir -p "$directory"
  local log=$directory/build.log
  if ! { cmake --preset "$preset" && cmake --build --preset "$preset" --parallel "$jobs"; } >"$log" 2>&1; then
    grep -B 4 -E '^(Fatal )?Error:|: error:|^CMake Error' "$log" | head -n 60 || tail -n 40 "$log"
    say "The $preset build failed; all of its output is in $log"
    say "(After a change of compiler, packages or module names: remove $directory and try again.)"
    return 1
  fi
  # What was found up to date is so: see built
  [[ ! -x $directory/femdem ]] || touch "$directory/femdem"
}
