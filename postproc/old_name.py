"""Commands by the names they had: plot_NAME.py is femdem-plot NAME; run_network.py, make_mesh.py and make_traces.py of
input/network are femdem-network, femdem-mesh and femdem-traces. Links of those names lead here; they go with the next version.
"""

import sys
from pathlib import Path

NEW = {"run_network": "network", "make_mesh": "mesh", "make_traces": "traces"}


def main():
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    from femdem.__main__ import main as command

    old = Path(sys.argv[0]).stem
    words = [NEW[old]] if old in NEW else ["plot", old.removeprefix("plot_")]
    print(f"{old}.py is called bin/femdem-{' '.join(words)} now", file=sys.stderr)
    return command([*words, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
