"""The commands without installing: python3 -m femdem plot ... is femdem-plot ..., and so on."""

import importlib
import sys

COMMANDS = {
    "plot": "femdem.figures.command",
    "network": "femdem.network.run_network",
    "mesh": "femdem.network.make_mesh",
    "traces": "femdem.network.make_traces",
    "convert": "femdem.convert",
    "sweep": "femdem.sweep.command",
    "numbers": "femdem.network.network_numbers",
}


def main(words=None):
    name, *words = sys.argv[1:] if words is None else words or [""]
    if name not in COMMANDS:
        sys.exit(f"usage: python3 -m femdem {{{','.join(COMMANDS)}}} ...")
    return importlib.import_module(COMMANDS[name]).main(words)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.argv.append("")
    sys.exit(main())
