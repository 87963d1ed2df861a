"""Meshes of other programs: what they become, that the program takes them, and that what it cannot take is refused."""

import subprocess

import numpy as np
import pytest

SIDE, PARTS = 2000.0, 8  # mm, squares along a side
DECK = """&run title = 'A plate from elsewhere', mesh = 'plate.msh' /
&material group = 'LOWER', density = 2700, young = 30e9, poisson = 0.27 /
&material group = 'UPPER', density = 2700, young = 30e9, poisson = 0.27 /
&joint group = 'JOINT', law = 'coulomb', friction_angle = 30, cohesion = 0, kn_mpa_mm = 10, ks_mpa_mm = 5 /
&boundary group = 'BOTTOM', vy = 0 /
&boundary group = 'CORNER', vx = 0 /
&boundary group = 'TOP', pressure = 1e6 /
&stage name = 'load', move_time = 1e-3 /
"""


def abaqus(kind):
    """A square plate of CPE4, CPE8 or CPE3 in mm with a joint across the middle, as Abaqus input"""
    step = 2 if kind == "CPE8" else 1
    number = step * PARTS + 1
    along = np.linspace(0.0, SIDE, number)
    half = number // 2
    text = ["*HEADING", "a plate", "*NODE"]

    def node(i, j):
        return j * number + i + 1

    text += [f"{node(i, j)}, {along[i]}, {along[j]}" for j in range(number) for i in range(number)]
    text.append(f"*ELEMENT, TYPE={kind}, ELSET=ALL")
    sets = {"LOWER": [], "UPPER": []}
    count = 0
    for b in range(PARTS):
        for a in range(PARTS):
            i, j = step * a, step * b
            corners = [node(i, j), node(i + step, j), node(i + step, j + step), node(i, j + step)]
            elements = [corners]
            if kind == "CPE8":
                elements = [
                    [*corners, node(i + 1, j), node(i + 2, j + 1), node(i + 1, j + 2), node(i, j + 1)]
                ]
            if kind == "CPE3":
                elements = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
            for element in elements:
                count += 1
                text.append(f"{count}, " + ", ".join(map(str, element)))
                sets["LOWER" if b < PARTS // 2 else "UPPER"].append(count)
    nodes = {
        "JOINT": [node(i, half) for i in range(number)],
        "BOTTOM": [node(i, 0) for i in range(number)],
        "TOP": [node(i, number - 1) for i in range(number)],
        "CORNER": [node(0, 0)],
    }
    for word, groups in (("ELSET", sets), ("NSET", nodes)):
        for name, members in groups.items():
            text.append(f"*{word}, {word}={name}")
            text += [", ".join(map(str, members[k : k + 8])) for k in range(0, len(members), 8)]
    return "\n".join([*text, ""])


@pytest.fixture
def plate(tmp_path, commands):
    """Convert a plate of a kind of element"""

    def convert(kind, *options, status=0):
        (tmp_path / "plate.inp").write_text(abaqus(kind))
        return commands(
            "convert", "plate.inp", "plate.msh", "--scale", "0.001", *options, cwd=tmp_path, status=status
        )

    convert.folder = tmp_path
    return convert


@pytest.mark.parametrize("kind", ["CPE3", "CPE4", "CPE8"])
def test_an_abaqus_plate_bears_its_load(kind, plate, femdem):
    said = plate(kind, "--fracture", "JOINT")
    assert "81 nodes, 128 triangles, 2 m by 2 m" in said
    assert "curve    'JOINT': 8 edges" in said
    assert ("cut into two triangles" in said) == (kind != "CPE3")
    assert ("corners alone" in said) == (kind == "CPE8")
    (plate.folder / "deck.nml").write_text(DECK)
    done = subprocess.run(
        [femdem, "--output", "results", "deck.nml"],
        cwd=plate.folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr
    from femdem import Results

    history = Results(plate.folder / "results").history
    # 1 MPa on a joint of 10 MPa/mm
    assert history["JOINT.normal_stress_MPa"][-1] == pytest.approx(1.0, rel=1e-6)
    assert history["JOINT.closure_mm"][-1] == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("suffix", ["vtu", "vtk", "xdmf", "med"])
def test_other_formats_give_the_same_mesh(suffix, plate, commands):
    import meshio

    plate("CPE4", "--fracture", "JOINT")
    own = meshio.read(plate.folder / "plate.msh")
    # Triangles and lines: XDMF has no mixture of single points
    wide = [k for k, block in enumerate(own.cells) if block.type != "vertex"]
    other = meshio.Mesh(
        own.points,
        [own.cells[k] for k in wide],
        cell_data={"part": [own.cell_data["gmsh:physical"][k].astype(int) for k in wide]},
    )
    path = plate.folder / f"other.{suffix}"
    meshio.write(path, other)
    said = commands("convert", path.name, "back.msh", "--groups", "part", cwd=plate.folder)
    assert "81 nodes, 128 triangles" in said
    back = meshio.read(plate.folder / "back.msh")
    np.testing.assert_array_equal(back.points, own.points)
    for kind in ("triangle", "line"):
        first, second = own.cell_data_dict["gmsh:physical"][kind], back.cell_data_dict["gmsh:physical"][kind]
        names = [{tag: name for name, (tag, _) in mesh.field_data.items()} for mesh in (own, back)]
        expected = {
            tuple(nodes): str(tag) for nodes, tag in zip(own.cells_dict[kind].tolist(), first, strict=True)
        }
        found = {
            tuple(nodes): names[1][tag]
            for nodes, tag in zip(back.cells_dict[kind].tolist(), second, strict=True)
        }
        assert found == expected


def test_a_gmsh_mesh_keeps_its_names(plate, commands):
    plate("CPE4", "--fracture", "JOINT")
    said = commands("convert", "plate.msh", "again.msh", cwd=plate.folder)
    for text in (
        "surface  'LOWER': 64",
        "surface  'UPPER': 64",
        "curve    'JOINT': 8",
        "points   'CORNER': 1",
    ):
        assert text in said


WRONG = {
    "unknown set": (
        ["--surfaces", "ROCK"],
        "--surfaces ROCK: there is no such set of triangles; there are: LOWER, UPPER, ALL",
    ),
    "unknown fracture": (["--fracture", "FAULT"], "there are: JOINT, BOTTOM, TOP, CORNER"),
    "no fracture": (["--fracture", "TOP"], "--fracture TOP: no inner edge"),
    "twice": (
        ["--surfaces", "ALL", "LOWER"],
        "64 triangles are in several sets (ALL, LOWER); choose with --surfaces",
    ),
    "part": (["--surfaces", "LOWER"], "64 triangles are in no set"),
    "plane": (["--plane", "xz"], "give --plane xy"),
    "array": (["--groups", "part"], "--groups part: there is no array"),
    "scale": (["--scale", "-1"], "--scale -1: it must be positive"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_options_are_refused_with_what_would_be_right(case, plate):
    options, said = WRONG[case]
    out = plate("CPE4", *options, status=2)
    assert said in out
    assert not (plate.folder / "plate.msh").exists()


def test_three_dimensions_are_refused(tmp_path, commands):
    import meshio

    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "solid.vtu")
    said = commands("convert", "solid.vtu", cwd=tmp_path, status=2)
    assert "mesh a section of it" in said
    assert "1 elements of type 'tetra'" in said
    assert "gmsh -2" in said


def test_files_that_are_none_are_named(tmp_path, commands):
    (tmp_path / "junk.vtu").write_text("junk")
    (tmp_path / "junk.odt").write_text("junk")
    assert "junk.vtu: no mesh was read" in commands("convert", "junk.vtu", cwd=tmp_path, status=2)
    assert "meshio reads" in commands("convert", "junk.odt", cwd=tmp_path, status=2)
    assert "no such file" in commands("convert", "none.inp", cwd=tmp_path, status=2)
    assert "say what its results become" in commands("convert", tmp_path, status=2)
