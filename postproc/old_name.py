"""Commands by the names they had: plot_NAME.py is femdem-plot NAME; run_network.py, make_mesh.py and make_traces.py of
input/network are femdem-network, femdem-mesh and femdem-traces. Links of those names lead here; they go with the next version.

The command runs with the Python that has what it needs, whichever this one is.
"""

import os
import sys
from pathlib import Path

NEW = {"run_network": "network", "make_mesh": "mesh", "make_traces": "traces"}


def main():
    old = Path(sys.argv[0]).stem
    name, *words = [NEW[old]] if old in NEW else ["plot", old.removeprefix("plot_")]
    print(f"{old}.py is called bin/femdem-{' '.join([name, *words])} now", file=sys.stderr, flush=True)
    command = Path(__file__).resolve().parent.parent / "bin" / f"femdem-{name}"
    os.execv(command, [str(command), *words, *sys.argv[1:]])


if __name__ == "__main__":
    main()
