"""The four formats of gmsh files give one mesh: a graded mesh with fractures that bend, cross, abut and end, written by
gmsh as 2.2 and 4.1, text and binary, goes through a short run; the meshes in the results are compared.
"""

import csv
import itertools
import math
import subprocess

import h5py
import numpy as np
import pytest

gmsh = pytest.importorskip("gmsh")

FORMATS = [(2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)]
# gmsh writes text with 16 digits: the last bit of a coordinate may differ from the binary file's.
TEXT_ROUNDING = 1.0e-15
# The table of block edges holds ten digits
TABLE_ROUNDING = 1.0e-9
# Fractures, each a line of points: a cross; a bend from the boundary to one of its arms; one that abuts on the other
FRACTURES = {
    "long": [[(0.2, 0.3), (1.7, 1.6)], [(0.3, 1.6), (1.5, 0.4)]],
    "short": [[(0.0, 1.0), (0.3, 1.1), (0.4, 1.5)], [(1.2, 1.9), (1.3, 1.2533333333333334)]],
}
# Block edges: the cross at x = 0.95 has four arms, two of which are parted by what abuts on them at x = 0.4 and 1.3
UP, DOWN = math.hypot(1.5, 1.3) / 1.5, math.sqrt(2.0)
LENGTHS = [
    *(UP * part for part in (0.95 - 0.2, 1.3 - 0.95, 1.7 - 1.3)),
    *(DOWN * part for part in (0.4 - 0.3, 0.95 - 0.4, 1.5 - 0.95)),
    math.hypot(0.3, 0.1) + math.hypot(0.1, 0.4),
    math.hypot(0.1, 1.9 - 1.2533333333333334),
]
DECK = """&run title = 'One mesh', mesh = 'network.msh' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
&joint group = 'long', law = 'coulomb', friction_angle = 30, cohesion = 0, kn_mpa_mm = 10, ks_mpa_mm = 5 /
&joint group = 'short', law = 'coulomb', friction_angle = 30, cohesion = 0, kn_mpa_mm = 10, ks_mpa_mm = 5 /
&boundary group = 'corner', vx = 0, vy = 0 /
&boundary group = 'outer', pressure = 1e6 /
&stage name = 'load', move_time = 1e-6 /
"""


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    """Directory with the mesh in the four formats."""
    directory = tmp_path_factory.mktemp("network")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("network")
        build()
        for version, binary in FORMATS:
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.write(str(directory / f"{version}_{binary}.msh"))
    finally:
        gmsh.finalize()
    return directory


def build():
    """The model and its mesh, finer towards one corner."""
    occ = gmsh.model.occ
    square = (2, occ.addRectangle(0, 0, 0, 2, 2))
    lines, owner = [], []
    for name, fractures in FRACTURES.items():
        for points in fractures:
            tags = [occ.addPoint(x, y, 0) for x, y in points]
            for a, b in itertools.pairwise(tags):
                lines.append((1, occ.addLine(a, b)))
                owner.append(name)
    _, pieces = occ.fragment([square], lines)
    occ.synchronize()
    surfaces = [tag for _, tag in pieces[0]]
    gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, surfaces), "rock")
    inside = set()
    for name in FRACTURES:
        tags = {tag for piece, of in zip(pieces[1:], owner, strict=True) if of == name for _, tag in piece}
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, sorted(tags)), name)
        inside |= tags
    outer = [tag for _, tag in gmsh.model.getEntities(1) if tag not in inside]
    gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, outer), "outer")
    corner = gmsh.model.getEntitiesInBoundingBox(-1e-6, -1e-6, -1e-6, 1e-6, 1e-6, 1e-6, 0)[0][1]
    gmsh.model.setPhysicalName(0, gmsh.model.addPhysicalGroup(0, [corner]), "corner")
    gmsh.model.mesh.setSize(gmsh.model.getEntities(0), 0.1)
    gmsh.model.mesh.setSize([(0, corner)], 0.01)
    gmsh.model.mesh.generate(2)


def run(femdem, network, name):
    """Run the scene on one of the meshes; the datasets that describe the mesh, the lengths of block edges."""
    directory = network / name.replace(".msh", "")
    directory.mkdir()
    (directory / "network.msh").write_bytes((network / name).read_bytes())
    (directory / "deck.nml").write_text(DECK)
    command = [femdem, "--quiet", "--output", "results", "deck.nml"]
    result = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stderr
    datasets = {}
    with h5py.File(directory / "results" / "fields.h5") as file:
        file["mesh"].visititems(
            lambda path, item: datasets.update({path: item[()]}) if isinstance(item, h5py.Dataset) else None
        )
    with open(directory / "results" / "edges.csv", newline="", encoding="utf-8") as file:
        lengths = [float(row["length_m"]) for row in csv.DictReader(file)]
    return datasets, lengths


@pytest.mark.fast
def test_four_formats_give_one_mesh(femdem, network):
    first, lengths = run(femdem, network, "2.2_0.msh")
    assert first
    np.testing.assert_allclose(sorted(lengths), sorted(LENGTHS), rtol=TABLE_ROUNDING)
    for name in ("2.2_1.msh", "4.1_0.msh", "4.1_1.msh"):
        found, found_lengths = run(femdem, network, name)
        assert found.keys() == first.keys()
        for path, value in first.items():
            if np.issubdtype(value.dtype, np.floating):
                np.testing.assert_allclose(found[path], value, rtol=0, atol=TEXT_ROUNDING, err_msg=path)
            else:
                np.testing.assert_array_equal(found[path], value, err_msg=path)
        np.testing.assert_allclose(found_lengths, lengths, rtol=TABLE_ROUNDING)


def square(directory, name, **options):
    """Two squares of one body, written by gmsh with some options."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        tag = gmsh.model.occ.addRectangle(0, 0, 0, 1, 2)
        gmsh.model.occ.synchronize()
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [tag]), "rock")
        bottom = gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, -0.1, 1.1, 0.1, 0.1, 1)[0][1]
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, [bottom]), "bottom")
        gmsh.model.mesh.generate(2)
        for option, value in options.items():
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.write(str(directory / name))
    finally:
        gmsh.finalize()


PLAIN = """&run mesh = 'square.msh' /
&material group = 'rock', density = 2700, young = 30e9, poisson = 0.27 /
&boundary group = 'bottom', vx = 0, vy = 0 /
&stage name = 'load', move_time = 1 /
"""


def check(femdem, directory, status=0):
    (directory / "deck.nml").write_text(PLAIN)
    command = [femdem, "--check", "deck.nml"]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == status, done.stdout + done.stderr
    return done


@pytest.mark.fast
@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_parametric_nodes(version, binary, femdem, tmp_path):
    square(tmp_path, "square.msh", MshFileVersion=version, Binary=binary)
    plain = check(femdem, tmp_path).stdout
    square(tmp_path, "square.msh", MshFileVersion=version, Binary=binary, SaveParametric=1)
    assert check(femdem, tmp_path).stdout == plain


@pytest.mark.fast
@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_everything_saved(version, binary, femdem, tmp_path):
    """Format 4.1 keeps the groups; 2.2 loses them, of which there is one message and no other."""
    square(tmp_path, "square.msh", MshFileVersion=version, Binary=binary, SaveAll=1)
    done = check(femdem, tmp_path, status=2 if version == 2.2 else 0)
    if version == 2.2:
        assert "(Mesh.SaveAll = 1) loses the groups in format 2.2" in done.stderr
        assert len(done.stderr.splitlines()) == 1, done.stderr


def shift_tags(text, by):
    """A text file of format 4.1 with all numbers of nodes and elements raised."""
    lines, out, section = iter(text.splitlines()), [], ""
    for line in lines:
        out.append(line)
        if line.startswith("$"):
            section = line
        if section not in ("$Nodes", "$Elements") or not line.startswith("$"):
            continue
        blocks, total, least, highest = map(int, next(lines).split())
        out.append(f"{blocks} {total} {least + by} {highest + by}")
        for _ in range(blocks):
            head = next(lines)
            out.append(head)
            count = int(head.split()[3])
            for _ in range(count):
                out.append(" ".join(str(int(word) + by) for word in next(lines).split()))
            if section == "$Nodes":
                out += [next(lines) for _ in range(count)]
    return "\n".join([*out, ""])


@pytest.mark.fast
@pytest.mark.parametrize("by", [2**31 - 3, 2**40, 10**17])
def test_numbers_of_any_size(by, femdem, tmp_path):
    square(tmp_path, "square.msh", MshFileVersion=4.1)
    plain = check(femdem, tmp_path).stdout
    path = tmp_path / "square.msh"
    path.write_text(shift_tags(path.read_text(), by))
    assert check(femdem, tmp_path).stdout == plain


@pytest.mark.fast
def test_what_gmsh_passes_over(femdem, tmp_path):
    """Comments, text between sections, and nodes that nothing uses, wherever they are."""
    square(tmp_path, "square.msh", MshFileVersion=2.2)
    plain = check(femdem, tmp_path).stdout
    path = tmp_path / "square.msh"
    text = path.read_text().replace(
        "$EndMeshFormat\n", "$EndMeshFormat\nmade by hand\n$Comments\n3 words here\n$EndComments\n"
    )
    head, count, rest = text.partition("$Nodes\n")
    number, _, rest = rest.partition("\n")
    text = f"{head}{count}{int(number) + 1}\n777 1e3 1e3 1e3\n{rest}"
    path.write_text("% a mesh\n$Comments\nby gmsh\n$EndComments\n" + text + "the end\n")
    assert check(femdem, tmp_path).stdout == plain


@pytest.mark.fast
@pytest.mark.parametrize(("scale", "warned"), [(1e3, True), (1, False), (1e-4, True)])
def test_lengths_that_are_hardly_metres(scale, warned, femdem, network, tmp_path):
    text = (network / "2.2_0.msh").read_text()
    head, start, rest = text.partition("$Nodes\n")
    nodes, end, tail = rest.partition("$EndNodes")
    lines = nodes.splitlines()
    scaled = [lines[0]]
    for line in lines[1:]:
        number, *place = line.split()
        scaled.append(" ".join([number, *(repr(scale * float(word)) for word in place)]))
    (tmp_path / "network.msh").write_text(head + start + "\n".join(scaled) + "\n" + end + tail)
    (tmp_path / "deck.nml").write_text(DECK)
    command = [femdem, "--check", "deck.nml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert ("is the mesh in metres?" in done.stderr) == warned
    extent = next(line.split() for line in done.stdout.splitlines() if line.startswith("extent"))
    assert [float(extent[1]), float(extent[4])] == [2 * scale, 2 * scale]
