"""No crack in phase I, some in II-B; each at rest; a bond that opens spends G_I; most start at fractures."""

import csv
import re
from pathlib import Path

import numpy as np

from scene import read_history

# Fracture energy of the deck [J/m2]
G_I = 100.0
# A bond that is put in at a stress within the strength spends what its spring takes up on the way to it on top (10 %),
# and one is broken when two of its three points are (5 of 18 may be left)
LEAST, MOST = 0.7, 1.15
AT_REST = 1e-6
# Of the work put in; found: 1e-5
ENERGY = 1e-3


def check(results):
    results = Path(results)
    with open(results / "cracks.csv", encoding="utf-8") as file:
        cracks = list(csv.DictReader(file))
    phases = [crack["stage"] for crack in cracks]
    print(f"{len(cracks)} broken bonds in phases {sorted(set(phases))}")
    assert "phase_1" not in phases, "cracks under equal stress from all sides"
    assert len(cracks) >= 4, "hardly anything breaks"
    opened = [float(c["energy_J"]) / float(c["length_m"]) for c in cracks if c["mode"] == "I"]
    print(f"energy of mode I over G_I: {np.min(opened) / G_I:.3f} to {np.max(opened) / G_I:.3f}")
    assert opened, "no bond opened"
    assert min(opened) > LEAST * G_I, opened
    assert max(opened) < MOST * G_I, opened
    ratios = re.findall(
        r"unbalanced force ratio ([0-9.E+-]+)", (results / "run.log").read_text(encoding="utf-8")
    )
    assert len(ratios) == 2, ratios
    assert max(map(float, ratios)) <= AT_REST, ratios
    history = read_history(results / "history.csv")
    residual = np.abs(history["residual_J"]).max() / history["external_J"][-1]
    print(f"energy residual {residual:.1e} of the work put in")
    assert residual < ENERGY, f"energy residual {residual:.1e}"
