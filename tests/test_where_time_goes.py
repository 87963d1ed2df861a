"""Every run ends by saying where its time went, in the log too when it is quiet."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

SPECIMENS = Path(__file__).resolve().parent / "scenes" / "_specimens" / "specimens.py"
DECK = """&run title = 'Where time goes', mesh = 'scene.msh', solver = '{solver}' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
{cohesive}
&boundary group = 'bottom', vy = 0.01 /
&boundary group = 'top', vy = -0.01 /
&boundary group = 'left', vx = 0 /
&stage name = 'compress', cycles = 5, move_time = 4e-3, profile = 'constant' /
"""
COHESIVE = (
    "&cohesive group = 'all', insertion = 'everywhere', tensile_strength = 7e6, cohesion = 15e6, "
    "friction_angle = 26.6, g_i = 100, g_ii = 500 /"
)


def time_table(log):
    """Of a log: seconds and per cent of each kind of work, and the speed with its unit."""
    table = {
        kind.strip(): (float(seconds), float(part))
        for kind, seconds, part in re.findall(r"^time +(\S+) +([\d.]+) s +([\d.]+) %$", log, re.MULTILINE)
    }
    (speed, unit), *more = re.findall(r"^speed +(\S+) million (.+) a second$", log, re.MULTILINE)
    assert not more
    return table, float(speed), unit


@pytest.mark.fast
@pytest.mark.parametrize(
    ("solver", "cohesive", "unit", "expected"),
    [
        ("explicit", "", "triangle-steps", {"rock"}),
        ("explicit", COHESIVE, "triangle-steps", {"rock", "bonds"}),
        ("implicit", "", "unknowns times iterations", {"set-up"}),
    ],
    ids=["rock", "bonds", "implicit"],
)
def test_where_time_goes(solver, cohesive, unit, expected, femdem, tmp_path):
    mesher = [sys.executable, SPECIMENS, "rectangle", "--size", "0.05", "--out", tmp_path / "scene.msh"]
    subprocess.run(mesher, check=True, capture_output=True, timeout=120)
    deck = tmp_path / "deck.nml"
    deck.write_text(DECK.format(solver=solver, cohesive=cohesive), encoding="utf-8")
    done = subprocess.run(
        [femdem, "--quiet", "--output", tmp_path / "out", deck], check=True, capture_output=True
    )
    assert not done.stdout
    log = (tmp_path / "out" / "run.log").read_text(encoding="utf-8")
    table, speed, found_unit = time_table(log)
    assert found_unit == unit
    assert speed > 0
    assert expected <= set(table)
    # Rows of less than half a per cent are left out; each is rounded to a tenth of a second and of a per cent
    parts = [part for _, part in table.values()]
    assert parts == sorted(parts, reverse=True)
    assert min(parts) >= 0.5
    assert 91.0 <= sum(parts) <= 101.0
    elapsed = float(re.search(r"steps in (\S+) s; results", log).group(1))
    without = sum(seconds for kind, (seconds, _) in table.items() if kind != "set-up")
    assert without <= elapsed + 0.1 * len(table)
