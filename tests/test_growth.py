"""What a run costs grows with its size, not with the square of it: bodies, and outputs that are there already.

Four times as much takes four times as long; with the square it would be sixteen. The bar lies between.
"""

import resource
import subprocess
from xml.etree import ElementTree

import pytest

FACTOR, BAR = 4, 9
DECK = """&run mesh = 'squares.msh', solver = 'implicit' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.2 /
&boundary group = 'bottom', vx = 0, vy = 0 /
"""


def squares(number):
    """Mesh of squares of two triangles each, that touch nowhere."""
    nodes, elements = [], []
    for k in range(number):
        x, y, b = 1.5 * (k % 100), 1.5 * (k // 100), 4 * k
        nodes += [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        elements += [
            f"1 2 1 1 {b + 1} {b + 2}",
            f"2 2 2 1 {b + 1} {b + 2} {b + 3}",
            f"2 2 2 1 {b + 1} {b + 3} {b + 4}",
        ]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '1 1 "bottom"', '2 2 "rock"']
    lines += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += [f"{i} {x} {y} 0" for i, (x, y) in enumerate(nodes, start=1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{i} {element}" for i, element in enumerate(elements, start=1)]
    return "\n".join([*lines, "$EndElements", ""])


def seconds(command, directory):
    """User time of a command [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def growth(time_of, size):
    """Time of FACTOR times the size over that of the size, the least of two tries."""
    return min(time_of(FACTOR * size) / max(time_of(size), 1e-2) for _ in range(2))


@pytest.mark.fast
def test_bodies_are_found_in_linear_time(femdem, tmp_path):
    (tmp_path / "deck.nml").write_text(
        DECK.replace("implicit", "auto") + "&stage name = 'load', move_time = 1 /\n"
    )

    def time_of(bodies):
        (tmp_path / "squares.msh").write_text(squares(bodies))
        return seconds([femdem, "--check", "--quiet", "deck.nml"], tmp_path)

    assert growth(time_of, 3000) < BAR


@pytest.mark.fast
def test_snapshots_are_appended(femdem, tmp_path):
    (tmp_path / "squares.msh").write_text(squares(1))

    def time_of(snapshots):
        stage = f"&stage name = 'load', move_time = 1, cycles = {snapshots} /\n&output fields_every = 1 /\n"
        (tmp_path / "deck.nml").write_text(DECK + stage)
        spent = seconds([femdem, "--quiet", "deck.nml"], tmp_path)
        times = (
            ElementTree.parse(tmp_path / "results" / "fields.xdmf")
            .getroot()
            .findall("./Domain/Grid/Grid/Time")
        )
        found = [float(time.get("Value")) for time in times]
        assert found == pytest.approx([i + 1 for i in range(snapshots)])
        return spent

    assert growth(time_of, 150) < BAR
