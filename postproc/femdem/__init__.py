"""Results of JCM-FEMDEM in Python: readers, figures, fracture networks, other formats, sweeps.

    from femdem import Results

    results = Results("results")
    print(results.history["joint.shear_stress_MPa"].max())

Names are imported when they are first used, so that a command loads only what it needs.
"""

import importlib

__version__ = "0.1.0"
_HOME = {
    "Results": "results",
    "ResultsError": "results",
    "History": "results",
    "Edges": "results",
    "Fields": "results",
    "Mesh": "results",
    "Deck": "results",
    "parse_deck": "results",
    "Joint": "jcm",
}
__all__ = list(_HOME)


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__():
    return [*globals(), *_HOME]
