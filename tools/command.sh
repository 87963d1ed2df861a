#!/usr/bin/env bash
# The commands of the Python package in postproc/, run from the project without installing it: bin/femdem-plot, femdem-network, ...
# are links to this file. They take a Python that has what the package needs, whichever comes first in PATH; bin/python3 is it.
set -euo pipefail
source "$(dirname "$(realpath "${BASH_SOURCE[0]}")")/setup.sh"
choose_python
name=$(basename "$0")
[[ $name == python3 ]] && exec "$PYTHON" "$@"
exec "$PYTHON" -m femdem "${name#femdem-}" "$@"
