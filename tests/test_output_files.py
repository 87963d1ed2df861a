"""The fields file and its index as other programs read them: h5py, the XML parser, the bundled readers.

The files are those that the unit test of the fields module writes.
"""

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "postproc"))

import h5py  # noqa: E402

from femdem.results import Results  # noqa: E402

BUILD = Path(os.environ.get("FEMDEM_BUILD", ROOT / "build"))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Directory with two snapshots on one mesh, and one with two meshes"""
    program = BUILD / "tests" / "unit" / "test_fields"
    if not program.is_file():
        pytest.skip(f"{program} has not been built")
    directory = tmp_path_factory.mktemp("fields")
    done = subprocess.run([program], cwd=directory, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return directory / "scratch_fields"


def test_every_dataset_has_unit_and_description(results):
    with h5py.File(results / "two" / "fields.h5") as file:
        seen = []

        def visit(name, item):
            if isinstance(item, h5py.Dataset):
                seen.append(name)
                assert isinstance(item.attrs["unit"], str), name
                assert len(item.attrs["description"]) > 3, name

        file.visititems(visit)
        assert "mesh/coordinates" in seen
        assert "step_000002/stress_1" in seen


def test_provenance_is_text(results):
    provenance = Results(results / "two").fields.provenance
    for name in ("program", "version", "commit", "compiler", "compiler_options", "command", "date", "deck"):
        assert isinstance(provenance[name], str), name
        assert provenance[name], name


@pytest.mark.parametrize("part", ["fields", "joints"])
@pytest.mark.parametrize("name", ["two", "four"])
def test_index_is_well_formed_and_all_it_names_exists(results, name, part):
    root = ElementTree.parse(results / name / f"{part}.xdmf").getroot()
    assert root.get("Version") == "3.0"
    items = root.findall(".//DataItem")
    assert items
    for item in items:
        path, dataset = item.text.split(":")
        with h5py.File(results / name / path) as file:
            assert tuple(int(n) for n in item.get("Dimensions").split()) == file[dataset].shape, dataset
            kind = {"Int": "i", "Float": "f"}[item.get("NumberType")]
            assert (file[dataset].dtype.kind, file[dataset].dtype.itemsize) == (
                kind,
                int(item.get("Precision")),
            )
    times = [float(time.get("Value")) for time in root.findall(".//Time")]
    assert times == sorted(times)


def test_cells_refer_to_nodes_that_exist(results):
    mesh = Results(results / "two").fields.mesh()
    for cells in (mesh.triangles, mesh.joints, mesh.surface):
        assert cells.min() == 0 or cells is mesh.surface
        assert cells.max() < len(mesh.coordinates)
    assert mesh.group_name == ["rock", "joint"]
    assert mesh.joint_lines == pytest.approx(np.array([[[0.0, 0.0], [1.0, 0.0]]]))


def test_reader_takes_fields_from_snapshot_and_mesh(results):
    fields = Results(results / "two").fields
    assert list(fields.times) == [1.0, 2.0]
    assert fields.read("jrcn") == pytest.approx([12.0])
    assert fields.read("displacement").shape == (6, 2)
    assert fields.read("shear_displacement_mm", 0) == pytest.approx([100.0])
    assert fields.names()["stress_1"][:2] == ("triangles", "Pa")
    assert len(Results(results / "four").fields.mesh(-1).joints) == 0
    assert len(Results(results / "four").fields.mesh(0).joints) == 1


@pytest.mark.usefixtures("results")
def test_an_open_reader_does_not_stop_the_run(tmp_path):
    """ParaView keeps its files open: writing must go on all the same."""
    subprocess.run([BUILD / "tests" / "unit" / "test_fields"], cwd=tmp_path, capture_output=True, check=False)
    # A reader that locks, in a process of its own because the setting is read once
    code = (
        "import h5py, subprocess, sys;"
        "file = h5py.File('scratch_fields/two/fields.h5', 'r');"
        f"sys.exit(subprocess.run([{str(BUILD / 'tests' / 'unit' / 'test_fields')!r}]).returncode)"
    )
    environment = {key: value for key, value in os.environ.items() if key != "HDF5_USE_FILE_LOCKING"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
