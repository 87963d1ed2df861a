"""A crack that grows steadily between the two halves of a beam that are pulled apart, by the implicit solver.

There is a rest at every opening, and the solver is to find it without a snap, in few iterations: the matrix without softening
leaves half of the force in each where the crack grows.
"""

import re
import subprocess

import pytest

from femdem.results import Results

LENGTH, HEIGHT, NOTCH, MOUTH = 0.4, 0.16, 0.1, 4e-3
COLUMNS, ROWS = 40, 16
DECK = """&run mesh = 'beam.msh', solver = '{}' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.2 /
&cohesive group = 'rock', tensile_strength = 4e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500 /
&boundary group = 'upper', vx = 0, vy = 1e-4 /
&boundary group = 'lower', vx = 0, vy = -1e-4 /
&stage name = 'open', move_time = {}, cycles = {} /
"""


def beam(turned):
    """Mesh of a beam with a wedge-shaped notch from one end along its middle, squares of four triangles; turned upside down or
    not, which leaves it what it is but numbers all otherwise."""
    sign = -1 if turned else 1
    nodes, number = [], {}

    def at(i, j, above):
        x, y = LENGTH * i / COLUMNS, HEIGHT * (j / ROWS - 0.5)
        open_here = j == ROWS // 2 and x < NOTCH - 1e-9
        key = (i, j, above and open_here)
        if key not in number:
            y += (0.5 * MOUTH * (1 - x / NOTCH) * (1 if above else -1)) if open_here else 0
            nodes.append((x, sign * y))
            number[key] = len(nodes)
        return number[key]

    rock = []
    for j in range(ROWS):
        for i in range(COLUMNS):
            above = j >= ROWS // 2
            corners = [at(i, j, above), at(i + 1, j, above), at(i + 1, j + 1, above), at(i, j + 1, above)]
            nodes.append((LENGTH * (i + 0.5) / COLUMNS, sign * HEIGHT * ((j + 0.5) / ROWS - 0.5)))
            for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
                rock.append((a, b, len(nodes))[::sign])
    ends = {1: range(ROWS // 2, ROWS), 2: range(ROWS // 2)}
    upper, lower = (2, 1) if turned else (1, 2)
    elements = [
        f"1 2 {group} {group} {at(0, j, half == 1)} {at(0, j + 1, half == 1)}"
        for half, group in ((1, upper), (2, lower))
        for j in ends[half]
    ]
    elements += [f"2 2 3 3 {a} {b} {c}" for a, b, c in rock]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3"]
    lines += ['1 1 "upper"', '1 2 "lower"', '2 3 "rock"', "$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += [f"{i} {x} {y} 0" for i, (x, y) in enumerate(nodes, start=1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{i} {element}" for i, element in enumerate(elements, start=1)]
    return "\n".join([*lines, "$EndElements", ""])


def pull(femdem, folder, cycles=16, turned=False, solver="implicit"):
    """History of a run, and what it printed."""
    folder.mkdir()
    (folder / "beam.msh").write_text(beam(turned))
    (folder / "deck.nml").write_text(DECK.format(solver, 0.8 / cycles, cycles))
    done = subprocess.run(
        [femdem, "deck.nml"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return Results(folder / "results").history, done.stdout


@pytest.mark.fast
def test_steady_crack_is_found_in_few_iterations_without_a_snap(femdem, tmp_path):
    history, said = pull(femdem, tmp_path / "a")
    # 758 with a matrix that leaves softening out, and snaps that take 1.5 of 14 J
    assert int(re.search(r"(\d+) iterations", said).group(1)) < 450
    assert "pseudo-time" not in said
    assert history["damping_J"][-1] < 0.02 * history["external_J"][-1]
    # The crack zone has grown by some six elements
    assert history["fracture_J"][-1] > 0.06 * 100


def test_steady_crack_whatever_the_drawing_the_increments_and_the_solver(femdem, tmp_path):
    one, _ = pull(femdem, tmp_path / "a")
    other, _ = pull(femdem, tmp_path / "b", turned=True)
    finer, _ = pull(femdem, tmp_path / "c", cycles=32)
    relaxed, _ = pull(femdem, tmp_path / "d", solver="relaxation")
    for name in ("external_J", "strain_J", "fracture_J"):
        assert other[name][-1] == pytest.approx(one[name][-1], rel=2e-3), name
        assert relaxed[name][-1] == pytest.approx(one[name][-1], rel=2e-3), name
        assert finer[name][-1] == pytest.approx(one[name][-1], rel=1e-2), name
