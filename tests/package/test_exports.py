"""The installed package: commands, and results as objects and files of other libraries, with the numbers of the results."""

import csv
import json
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

import femdem
from femdem import Results, ResultsError, exports
from femdem.results import Edges
from femdem.sweep.collect import collect

DIGITS = 1e-9  # tables hold ten to twelve digits


def test_it_is_the_installed_one():
    assert "site-packages" in femdem.__file__


@pytest.mark.parametrize("name", ["plot", "network", "mesh", "traces", "convert", "sweep"])
def test_every_command_explains_itself(name, commands):
    assert f"usage: femdem-{name}" in commands(name, "--help")


def test_figures_and_network_need_no_checkout(commands, shear, tmp_path):
    commands("plot", "direct_shear", shear, "--out", tmp_path / "figure")
    assert (tmp_path / "figure.png").stat().st_size > 10_000
    said = commands("network", "nothing.csv", cwd=tmp_path, status=2)
    assert "nothing.csv: there is no such file (traces)" in said
    assert "phase_1.nml" not in said  # the deck came with the package


def test_history_to_pandas(shear):
    frame = Results(shear).history.to_pandas()
    with open(shear / "history.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(frame.columns) == list(rows[0])
    assert len(frame) == len(rows) > 400
    expected = [float(row["joint.shear_stress_MPa"]) for row in rows]
    assert frame["joint.shear_stress_MPa"].tolist() == expected


def test_edges_to_geopandas(network):
    edges = Results(network).edges
    frame = edges.to_geopandas(crs="EPSG:2056")
    assert frame.crs.to_epsg() == 2056
    assert (frame.geometry.geom_type == "LineString").all()
    np.testing.assert_allclose(frame.length, edges.length_m, rtol=DIGITS)
    assert list(frame.index) == list(edges.id)
    assert frame["mean_aperture_mm"].tolist() == edges.mean_aperture_mm.tolist()


def test_edges_of_a_snapshot_are_those_of_the_table(network):
    run = Results(network)
    last, at_the_end = run.edges, Edges.at(run.fields, -1, run.edges)
    for name in Edges.names():
        if name != "group":
            np.testing.assert_allclose(
                getattr(at_the_end, name), getattr(last, name), rtol=DIGITS, atol=DIGITS
            )


def test_collected_numbers(network):
    run = Results(network)
    history, stage = run.history, run.history["stage"]
    aperture = history["fractures.aperture_mm"]
    end_of_first = aperture[stage == 1][-1]
    assert collect(run, "history.fractures.aperture_mm") == aperture[-1]
    assert collect(run, "history.fractures.aperture_mm @ phase_1") == end_of_first
    assert collect(run, "history.fractures.aperture_mm largest") == aperture.max()
    middle = history["time_s"][4]
    assert collect(run, f"history.fractures.aperture_mm @ t={middle}") == aperture[4]
    # The history's mean is over the length of the joints, and so is this one
    by_length = collect(run, "edges.mean_aperture_mm mean_by_length @ phase_1")
    assert by_length == pytest.approx(end_of_first, rel=DIGITS)
    assert by_length != pytest.approx(aperture[-1], rel=1e-3)
    for wrong in (
        "history.nothing",
        "nothing.time_s",
        "history.time_s @ phase_9",
        "edges.group",
        "edges.id @ t=x",
    ):
        with pytest.raises(ResultsError):
            collect(run, wrong)


def rock_and_joints(run):
    """What VTU, XDMF and pyvista must hold: numbers of cells, a field of each part, a displacement"""
    fields = run.fields
    return (
        (len(fields.mesh().triangles), len(fields.mesh().joints)),
        fields.read("stress_xx"),
        fields.read("aperture_mm"),
        fields.read("displacement"),
    )


def test_fields_to_pyvista(network):
    run = Results(network)
    cells, stress, aperture, displacement = rock_and_joints(run)
    blocks = run.fields.to_pyvista()
    assert blocks.keys() == ["rock", "joints"]
    assert (blocks["rock"].n_cells, blocks["joints"].n_cells) == cells
    np.testing.assert_array_equal(blocks["rock"].cell_data["stress_xx"], stress)
    np.testing.assert_array_equal(blocks["joints"].cell_data["aperture_mm"], aperture)
    np.testing.assert_array_equal(blocks["rock"].point_data["displacement"][:, :2], displacement)
    mesh = run.fields.mesh()
    corner = mesh.coordinates[mesh.triangles]
    (ax, ay), (bx, by) = (corner[:, 1] - corner[:, 0]).T, (corner[:, 2] - corner[:, 0]).T
    area = np.abs(ax * by - ay * bx).sum() / 2
    sizes = blocks["rock"].compute_cell_sizes()
    assert sizes.cell_data["Area"].sum() == pytest.approx(area, rel=DIGITS)


def test_vtu_files_with_their_times(network, commands, tmp_path):
    import pyvista

    run = Results(network)
    cells, stress, aperture, displacement = rock_and_joints(run)
    commands("convert", network, "--vtu", "--out", tmp_path)
    reader = pyvista.get_reader(tmp_path / "fields.pvd")
    assert reader.time_values == pytest.approx(run.fields.times.tolist(), rel=DIGITS)
    reader.set_active_time_value(reader.time_values[-1])
    rock, joints = reader.read()
    assert (rock.n_cells, joints.n_cells) == cells
    np.testing.assert_array_equal(rock.cell_data["stress_xx"], stress)
    np.testing.assert_array_equal(joints.cell_data["aperture_mm"], aperture)
    np.testing.assert_array_equal(rock.point_data["displacement"][:, :2], displacement)


def test_xdmf_for_meshio_and_vtk(network, commands):
    import meshio
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

    run = Results(network)
    cells, stress, aperture, _ = rock_and_joints(run)
    paths = commands("convert", network, "--xdmf").split()
    assert [path.rpartition("/")[2] for path in paths] == ["rock.xdmf", "joints.xdmf"]
    for path, name, number, values in zip(
        paths, ("stress_xx", "aperture_mm"), cells, (stress, aperture), strict=True
    ):
        assert ElementTree.parse(path).getroot().get("Version") == "3.0"
        with meshio.xdmf.TimeSeriesReader(path) as series:
            _, blocks = series.read_points_cells()
            times = [series.read_data(k)[0] for k in range(series.num_steps)]
            _, _, on_cells = series.read_data(series.num_steps - 1)
        assert sum(len(block) for block in blocks) == number
        assert times == pytest.approx(run.fields.times.tolist(), rel=DIGITS)
        np.testing.assert_array_equal(on_cells[name][0], values)
        reader = vtkXdmfReader()
        reader.SetFileName(path)
        reader.UpdateInformation()
        reader.UpdateTimeStep(times[-1])
        grid = reader.GetOutputDataObject(0)
        assert grid.GetNumberOfCells() == number
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray(name)), values)


def test_index_of_the_program_for_meshio_and_vtk(network):
    """The files beside the results: each part by meshio's series, both as blocks by VTK's reader"""
    import meshio
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

    run = Results(network)
    cells, stress, aperture, displacement = rock_and_joints(run)
    for name, field, number, values in zip(
        ("fields.xdmf", "joints.xdmf"), ("stress_xx", "aperture_mm"), cells, (stress, aperture), strict=True
    ):
        with meshio.xdmf.TimeSeriesReader(network / name) as series:
            points, blocks = series.read_points_cells()
            times = [series.read_data(k)[0] for k in range(series.num_steps)]
            _, on_points, on_cells = series.read_data(series.num_steps - 1)
        assert times == pytest.approx(run.fields.times.tolist(), rel=DIGITS)
        mesh = meshio.Mesh(points, blocks, point_data=on_points, cell_data=on_cells)
        assert sum(len(block) for block in mesh.cells) == number
        np.testing.assert_array_equal(mesh.cell_data[field][0], values)
        np.testing.assert_array_equal(mesh.point_data["displacement"][:, :2], displacement)
    reader = vtkXdmfReader()
    reader.SetFileName(str(network / "fields.xdmf"))
    reader.UpdateInformation()
    reader.UpdateTimeStep(times[-1])
    both = reader.GetOutputDataObject(0)
    assert both.GetNumberOfBlocks() == 2
    for index, (name, field, values) in enumerate(
        (("rock", "stress_xx", stress), ("joints", "aperture_mm", aperture))
    ):
        assert both.GetMetaData(index).Get(both.NAME()) == name
        block = both.GetBlock(index)
        assert block.GetNumberOfCells() == cells[index]
        np.testing.assert_array_equal(vtk_to_numpy(block.GetCellData().GetArray(field)), values)


def test_block_edges_for_a_gis(network, commands, tmp_path):
    path = tmp_path / "edges.geojson"
    commands("convert", network, "--gis", path, "--crs", "EPSG:2056")
    features = json.loads(path.read_text())["features"]
    assert len(features) == len(Results(network).edges)
    assert features[0]["geometry"]["type"] == "LineString"


def test_a_missing_library_is_named():
    code = "import sys; sys.modules['pandas'] = None\nfrom femdem import exports\nexports.library('pandas')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install './postproc[gis]'" in done.stderr


def test_results_without_joints_are_rock_alone(network):
    class Whole(type(Results(network).fields)):
        def mesh(self, step=-1):
            mesh = super().mesh(step)
            mesh.joints = mesh.joints[:0]
            return mesh

    assert exports.parts(Whole(network / "fields.h5")) == ["rock"]
