"""femdem-plot NAME RESULTS ...: draw a figure of one or several results directories."""

import importlib
import pkgutil
import sys

import femdem.figures as package
from femdem.results import ResultsError

SHARED = {"command", "maps", "style"}  # modules that are no figures
BAD_INPUT = 2


def names():
    """Names of the figures"""
    return sorted(
        module.name for module in pkgutil.iter_modules(package.__path__) if module.name not in SHARED
    )


def first_line(name):
    """What a figure shows"""
    text = importlib.import_module(f"{package.__name__}.{name}").__doc__
    return " ".join(text.partition("\n\n")[0].split())


def usage():
    """Every figure with what it shows"""
    lines = [f"  {name:16s} {first_line(name)}" for name in names()]
    return "\n".join(
        [
            "usage: femdem-plot FIGURE RESULTS [RESULTS ...] [options]",
            "",
            *lines,
            "",
            "femdem-plot FIGURE --help tells its options.",
        ]
    )


def main(words=None):
    """Draw a figure; what is wrong with the results is one line, not a traceback."""
    name, *rest = (sys.argv[1:] if words is None else list(words)) or ["--help"]
    if name in ("--help", "-h"):
        print(usage())
        return
    if name not in names():
        print(f"error: there is no figure {name!r}; there are: {', '.join(names())}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    try:
        importlib.import_module(f"{package.__name__}.{name}").main(rest)
    except ResultsError as error:
        sys.exit(f"error: {error}")
