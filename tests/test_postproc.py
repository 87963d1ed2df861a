"""Readers, the reference law and every figure script, on results made from the law itself."""

import contextlib
import csv
import io
import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest

os.environ.setdefault("MPLCONFIGDIR", tempfile.gettempdir())

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from fake_results import NORMAL_STRESS, cast_joint, write_closure, write_network, write_shear  # noqa: E402
from femdem.figures import command  # noqa: E402
from femdem.jcm import Joint  # noqa: E402
from femdem.results import Results, ResultsError, parse_deck  # noqa: E402

LENGTHS = [0.06, 0.12, 0.18, 0.36]  # m, of the paper's joints


@dataclass
class Done:
    """How a script ended"""

    returncode: int
    stdout: str
    stderr: str


def script(name, *arguments):
    """femdem-plot in this process: a new one would spend its time importing matplotlib"""
    out, err, status = io.StringIO(), io.StringIO(), 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            command.main([name, *map(str, arguments)])
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
        if isinstance(stop.code, str):
            err.write(stop.code)
    return Done(status, out.getvalue(), err.getvalue())


def check_figures(done, stem):
    """PDF and PNG are there, are what they say, and were named"""
    assert done.returncode == 0, done.stderr
    for suffix, start in ((".pdf", b"%PDF"), (".png", b"\x89PNG")):
        path = stem.with_name(stem.name + suffix)
        assert path.read_bytes().startswith(start)
        assert str(path) in done.stdout


# ---- The reference law: numbers worked out by hand and given in the theory page ----


@pytest.mark.parametrize(("length", "peak"), zip(LENGTHS, [43.62, 33.28, 29.52, 25.09], strict=True))
def test_peak_stress(length, peak):
    assert 1000 * cast_joint(length).peak_shear_stress(NORMAL_STRESS) == pytest.approx(peak, abs=0.005)


@pytest.mark.parametrize(("length", "closure"), zip(LENGTHS, [0.0470, 0.0624, 0.0744, 0.1033], strict=True))
def test_closure_at_one_megapascal(length, closure):
    assert cast_joint(length).closure(1.0) == pytest.approx(closure, abs=5e-5)


@pytest.mark.parametrize(
    ("length", "eq14", "eq15"),
    zip(LENGTHS, [0.742, 1.103, 1.390, 2.065], [0.426, 0.686, 0.895, 1.391], strict=True),
)
def test_peak_displacement(length, eq14, eq15):
    law = cast_joint(length)
    assert law.peak_displacement(NORMAL_STRESS) == pytest.approx(eq15, abs=5e-4)
    law.peak = "eq14"
    assert law.peak_displacement(NORMAL_STRESS) == pytest.approx(eq14, abs=5e-4)


def test_closure_and_stress_are_inverse():
    law = cast_joint(0.06)
    stress = np.linspace(0, 5, 30)
    assert law.normal_stress(law.closure(stress)) == pytest.approx(stress, abs=1e-12)


def test_dilation_before_the_peak_has_its_closed_form():
    law = cast_joint(0.12)
    up = float(law.peak_displacement(NORMAL_STRESS))
    m = law.damage_coefficient(NORMAL_STRESS)
    vp = up * np.tan(np.radians(law.jrcn * np.log10(law.jcsn / NORMAL_STRESS) / (3 * m)))
    r = np.linspace(0, 1, 41)
    assert law.dilation(r * up, NORMAL_STRESS) == pytest.approx(vp * (2 * r**2 - r), abs=1e-7)
    assert law.dilation(0.25 * up, NORMAL_STRESS) == pytest.approx(-vp / 8, abs=1e-7)


@pytest.mark.parametrize(("length", "dilation"), zip(LENGTHS, [0.98, 0.88, 0.80, 0.65], strict=True))
def test_dilation_at_five_millimetres(length, dilation):
    law = cast_joint(length)
    law.post_peak = "eq16"
    assert law.dilation(5.0, NORMAL_STRESS) == pytest.approx(dilation, abs=0.006)


def test_stress_starts_at_zero_and_peaks_at_the_peak():
    law = cast_joint(0.18)
    up = float(law.peak_displacement(NORMAL_STRESS))
    u = np.linspace(0, 5 * up, 5001)
    tau = law.shear_stress(u, NORMAL_STRESS)
    assert tau[0] == 0
    assert u[np.argmax(tau)] == pytest.approx(up, rel=1e-3)
    assert tau.max() == pytest.approx(law.peak_shear_stress(NORMAL_STRESS), rel=1e-9)


def test_no_dilation_where_the_stress_exceeds_the_strength():
    law = cast_joint(0.06)
    assert law.dilation(1.0, 3.0) == 0
    assert law.shear_stress(50.0, 3.0) == pytest.approx(3.0 * np.tan(np.radians(32)))


def test_total_angle_is_capped():
    assert np.all(cast_joint(0.06).mobilised_angle(np.linspace(0, 5, 100), 1e-6) <= 70.0 + 1e-12)


def test_guards_that_act_are_named():
    law = cast_joint(0.06)
    assert law.guards(NORMAL_STRESS) == []
    assert law.guards(1e-4) == ["angle capped"]  # 15 log10(2/1e-4) + 32 = 96 degrees
    assert law.guards(2.5) == ["sn >= JCSn"]
    smooth = Joint(jrc0=1, jcs0=2, l0=0.1, phi_r=30, length=0.1)  # kn0 = -7.15 + 1.75 + 2
    assert smooth.guards(0.1) == ["kn0 floored"]
    assert smooth.initial_stiffness == 0.1
    assert "vm floored" in Joint(jrc0=9.7, jcs0=169, l0=0.2, phi_r=31, length=0.05, a0=0.194).guards(1.0)


def test_closure_goes_on_along_its_tangent():
    law = cast_joint(0.06)
    kn0, vm = law.initial_stiffness, law.largest_closure
    limit = kn0 * vm * 0.99 / 0.01
    assert law.guards(1.01 * limit)[-1] == "closure > 0.99 vm"
    assert law.closure(limit) == pytest.approx(0.99 * vm, rel=1e-12)
    assert law.closure(2 * limit) == pytest.approx(0.99 * vm + limit / (kn0 / 0.01**2), rel=1e-12)
    assert law.normal_stress(law.closure(2 * limit)) == pytest.approx(2 * limit, rel=1e-12)


def test_wrong_choice_is_refused():
    with pytest.raises(ValueError, match="eq14"):
        Joint(15, 2, 0.06, 32, 0.06, peak="eq13")


# ---- Readers ----


def test_deck_is_read():
    groups = parse_deck(
        "&run title = 'it''s a/b, c', solver='auto' / \n&joint\n l0 = 6.0D-2 ! m\n active = .true.\n/\n"
    )
    assert groups == [
        ("run", {"title": "it's a/b, c", "solver": "auto"}),
        ("joint", {"l0": 0.06, "active": True}),
    ]


def test_history_of_a_run_that_goes_on(tmp_path):
    run = Results(write_shear(tmp_path))
    rows = len(run.history)
    with (tmp_path / "history.csv").open("a") as file:
        file.write("9.9,1000,2")
    assert len(run.history) == rows
    assert run.history.groups == ["joint"]
    with pytest.raises(ResultsError, match="no column 'nothing'"):
        run.history["nothing"]
    with pytest.raises(ResultsError, match="no joint group 'other'"):
        run.history.group("other")


def test_reference_joint_has_the_properties_of_the_deck(tmp_path):
    law = Results(write_shear(tmp_path, length=0.36)).reference_joint("joint")
    assert (law.jrc0, law.jcs0, law.l0, law.phi_r, law.length) == (15, 2, 0.06, 32, 0.36)
    assert law.a0 == pytest.approx(0.3)


def test_edges_and_fields(tmp_path):
    run = Results(write_network(tmp_path))
    assert run.edges.group[0] == "joint"
    assert run.edges.length_m[0] == 0.06
    fields = run.fields
    assert list(fields.times) == [0.1, 0.2]
    assert fields.provenance["commit"] == "some commit"
    assert fields.read("displacement").shape == (41 * 41, 2)
    assert fields.read("displacement", 0)[-1, 1] == pytest.approx(-4e-4)
    assert fields.read("jrcn")[0] == 9
    assert fields.names()["aperture_mm"] == ("joints", "mm", "aperture")
    assert fields.mesh().joint_lines.shape[1:] == (2, 2)
    with pytest.raises(ResultsError, match="no field 'nothing'"):
        fields.read("nothing")
    with pytest.raises(ResultsError, match="no snapshot 7"):
        fields.read("jrcn", 7)


def test_missing_results_are_said(tmp_path):
    with pytest.raises(ResultsError, match="no such directory"):
        Results(tmp_path / "none")
    with pytest.raises(ResultsError, match=r"history.csv: there is no such file"):
        _ = Results(tmp_path).history


# ---- Scripts ----


def test_plot_shear_finds_the_error_put_in(tmp_path):
    runs = [write_shear(tmp_path / f"{i}", length, 0.01) for i, length in enumerate(LENGTHS)]
    table = tmp_path / "errors.csv"
    done = script("shear", *runs, "--out", tmp_path / "shear", "--csv", table)
    check_figures(done, tmp_path / "shear")
    rows = [line.split(",") for line in table.read_text().splitlines()[1:]]
    # A sine of 1 % over many periods: rms 1/sqrt(2) %, worst 1 %
    assert [float(row[5]) for row in rows] == pytest.approx([0.01 * 100 / np.sqrt(2)] * 4, rel=0.05)
    assert [abs(float(row[6])) for row in rows] == pytest.approx([1.0] * 4, rel=0.01)


def test_plot_shear_takes_either_direction(tmp_path):
    done = script("shear", write_shear(tmp_path, direction=-1.0))
    check_figures(done, tmp_path / "figures" / "shear")


def test_plot_dilation(tmp_path):
    runs = [write_shear(tmp_path / f"{i}", length) for i, length in enumerate(LENGTHS)]
    table = tmp_path / "errors.csv"
    labels = ["6 cm", "12 cm", "18 cm", "36 cm"]
    done = script("dilation", *runs, "--labels", *labels, "--out", tmp_path / "d.pdf", "--csv", table)
    check_figures(done, tmp_path / "d")
    assert all(float(line.split(",")[4]) < 1e-3 for line in table.read_text().splitlines()[1:])


def test_plot_closure_finds_the_error_put_in(tmp_path):
    table = tmp_path / "errors.csv"
    done = script("closure", write_closure(tmp_path / "c", 0.06, 0.02), "--csv", table)
    check_figures(done, tmp_path / "c" / "figures" / "closure")
    rows = table.read_text().splitlines()[1:]
    assert len(rows) == 20
    assert all(float(row.split(",")[4]) == pytest.approx(2.0) for row in rows)


def test_plot_energy(tmp_path):
    done = script("energy", write_shear(tmp_path))
    check_figures(done, tmp_path / "figures" / "energy")
    assert "worst residual 0.001 %" in done.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["--rock", "stress_1"],
        ["--joints", "shear_displacement_mm", "--step", "0"],
        ["--joints", "aperture_mm", "--rock", "displacement.y", "--deformed", "100", "--magnitude"],
    ],
)
def test_plot_map(tmp_path, arguments):
    done = script("map", write_network(tmp_path), *arguments)
    check_figures(done, tmp_path / "figures" / "map")


def test_plot_map_without_joints(tmp_path):
    """A scene without joints, whose fields of joints are there and empty: the rock is drawn, joints alone are refused."""
    directory = write_network(tmp_path)
    with h5py.File(directory / "fields.h5", "r+") as file:
        for group in [file[name] for name in file if name.startswith(("mesh", "step_"))]:
            for name in list(group):
                if name in ("joints", "joint_lines", "joint_group", "block_edge") or (
                    "place" in group[name].attrs and group[name].attrs["place"] in ("joints", b"joints")
                ):
                    old, attributes = group[name][:0], dict(group[name].attrs)
                    del group[name]
                    group.create_dataset(name, data=old).attrs.update(attributes)
    done = script("map", directory, "--rock", "stress_1", "--joints", "aperture_mm")
    check_figures(done, tmp_path / "figures" / "map")
    assert "there are no joints at this time: aperture_mm is not drawn" in done.stdout
    done = script("map", directory, "--joints", "aperture_mm")
    assert done.returncode != 0
    assert "there are no joints at this time: aperture_mm cannot be drawn" in done.stderr
    assert "Traceback" not in done.stderr


def test_plot_map_lists_fields_and_refuses_unknown_ones(tmp_path):
    directory = write_network(tmp_path)
    assert "aperture_mm" in script("map", directory, "--list").stdout
    done = script("map", directory, "--rock", "nothing")
    assert done.returncode != 0
    assert "no field 'nothing'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("values", "unit", "expected", "shown"),
    [
        ([0.0, -1.4e-3], "m", [0.0, -1.4], "mm"),
        ([2e-5], "m", [20.0], "µm"),
        ([1.4], "m", [1.4], "m"),
        ([0.05], "m/s", [50.0], "mm/s"),
        ([0.3, 0.001], "mm", [0.3, 0.001], "mm"),
        ([3e-3], "mm", [3.0], "µm"),
        ([0.0], "m", [0.0], "m"),
        ([2e-3], "-", [2e-3], "-"),
        ([2e-3], "MPa", [2e-3], "MPa"),
    ],
)
def test_lengths_are_shown_in_a_unit_that_fits(values, unit, expected, shown):
    from femdem.figures.map import in_finer_unit

    found, name = in_finer_unit(np.array(values), unit)
    assert name == shown
    assert found == pytest.approx(expected)


def one_large_value(directory):
    """A network whose slip and aperture are 100 times those around them on one element of a long block edge"""
    directory = write_network(directory)
    import h5py

    with h5py.File(directory / "fields.h5", "a") as file:
        for name in ("shear_displacement_mm", "aperture_mm"):
            values = np.abs(file["step_000002"][name][...]) + 0.1
            values[5] *= 100
            file["step_000002"][name][...] = values
    return directory


def test_a_single_element_with_a_large_value_does_not_hide_the_map(tmp_path):
    from femdem.figures import maps as network_maps

    run = Results(one_large_value(tmp_path))
    panel = network_maps.Panel(run, -1, "")
    edge = run.fields.mesh().block_edge
    for quantity in network_maps.QUANTITIES:
        values, means = panel.values(quantity), panel.means(quantity)
        # As wide as the others of its block edge: the mean by length is that of all of them
        assert means[5] == pytest.approx(means[edge == edge[5]])
        length = network_maps.lengths(panel.lines())
        assert means[5] == pytest.approx(np.average(values[edge == edge[5]], weights=length[edge == edge[5]]))
        _, most = network_maps.common_limits([panel], quantity)
        assert np.delete(values, 5).max() / 2 < most <= np.delete(values, 5).max()


def test_the_value_beyond_the_colours_is_written_at_their_end(tmp_path):
    from matplotlib.collections import LineCollection

    from femdem.figures import maps as network_maps
    from femdem.figures import style as figure_style

    figure, axes = figure_style.plt.subplots()
    drawn = LineCollection(np.zeros((3, 2, 2)), array=np.array([0.0, 0.5, 40.0]))
    drawn.set_clim(0.0, 1.0)
    bar = network_maps.colour_bar(figure, drawn, axes, "Aperture [mm]", np.array([0.0, 0.5, 40.0]))
    assert bar.extend == "max"
    assert [text.get_text() for text in bar.ax.texts] == ["to 40"]
    bar = network_maps.colour_bar(figure, drawn, axes, "Aperture [mm]", np.array([0.0, 1.0]))
    assert bar.extend == "neither"
    assert not bar.ax.texts
    figure_style.plt.close(figure)
    for name, options in (("network", []), ("map", ["--joints", "aperture_mm"])):
        done = script(name, one_large_value(tmp_path / name), *options, "--out", tmp_path / name)
        check_figures(done, tmp_path / name)


def test_range_of_the_colours_goes_by_length():
    from femdem.figures import maps as network_maps

    values, length = np.array([1.0, 2.0, 3.0, 100.0]), np.array([50.0, 30.0, 19.5, 0.5])
    assert network_maps.inner_range(values, length) == (1.0, 3.0)
    assert network_maps.inner_range(values, length[::-1]) == (2.0, 100.0)


def write_cracks(directory):
    """Two cracks, one of them later than the snapshots"""
    with (directory / "deck.nml").open("a") as file:
        file.write("&cohesive group = 'rock' /\n")
    rows = ["time_s,stage,x_m,y_m,angle_deg,length_m,mode,energy_J"]
    rows += ["0.15,load,0.5,0.5,45,0.2,I,1.0", "0.3,load,1.5,1.5,0,0.1,II,1.0"]
    (directory / "cracks.csv").write_text("\n".join(rows) + "\n")
    return directory


def test_emission_has_the_b_value_of_its_events(tmp_path):
    """Magnitudes drawn with b = 1.2 give it back within its error; cracks side by side are one event with their summed tensor."""
    from femdem.figures import emission

    chance = np.random.default_rng(5)
    magnitude = -4 + chance.exponential(np.log10(np.e) / 1.2, 4000)
    _, b, error = emission.b_value(magnitude, -3.9)
    assert abs(b - 1.2) < 3 * error
    assert error < 0.03
    directory = write_network(tmp_path)
    names = "time_s,x_m,y_m,length_m,mxx_N,myy_N,mxy_N,mzz_N,magnitude"
    lines = [names, "1,0,0,1,0,0,1e6,0,-2", "1.1,0.5,0,1,0,0,1e6,0,-2", "1.1,9,0,1,0,0,1e6,0,-2"]
    (directory / "cracks.csv").write_text("\n".join(lines) + "\n")
    time, found = emission.read_events(Results(directory), (0.2, 1.0))
    assert sorted(time) == [1.0, 1.1]
    # Twice the moment per thickness on twice the width
    assert np.ptp(found) == pytest.approx(2 / 3 * np.log10(4))
    assert script("emission", directory, "--cluster", "0.2", "1.0", "--out", tmp_path / "emission")


def test_cracks_of_an_older_run_in_the_directory_are_not_drawn(tmp_path):
    from femdem.figures import maps as network_maps

    directory = write_cracks(write_network(tmp_path))
    assert len(network_maps.read_cracks(Results(directory)).lines) == 2
    deck = (directory / "deck.nml").read_text()
    (directory / "deck.nml").write_text(deck.replace("&cohesive group = 'rock' /", ""))
    assert len(network_maps.read_cracks(Results(directory)).lines) == 0


def test_short_block_edges_are_thinner():
    from femdem.figures import maps as network_maps

    # A block edge of two elements across the map, one of a single element of 1 % of it, a cohesive joint
    lines = np.array(
        [[[0, 0], [1, 0]], [[1, 0], [2, 0]], [[1, 0], [1, 0.02]], [[1, 1], [1, 1.05]]], dtype=float
    )
    found = network_maps.slenderness(np.array([1, 1, 2, 0]), lines)
    assert found == pytest.approx([1.0, 1.0, 0.2, 0.5])


@pytest.mark.parametrize("name", ["network", "models"])
def test_maps_side_by_side(tmp_path, name):
    runs = [write_network(tmp_path / f"{k}", seed=k) for k in range(2)]
    write_cracks(runs[1])
    done = script(name, *runs, "--out", tmp_path / name, "--labels", "first", "second")
    check_figures(done, tmp_path / name)
    cracks = [line.split()[-1] for line in done.stdout.splitlines() if "aperture_mm" in line]
    assert cracks == ["0", "1"]
    assert script(name, *runs, "--labels", "one").returncode != 0


def test_one_run_is_drawn_stage_by_stage(tmp_path):
    check_figures(script("network", write_network(tmp_path)), tmp_path / "figures" / "network")


def test_cracks_are_placed_by_centre_angle_and_length(tmp_path):
    from femdem.figures import maps as network_maps

    run = Results(write_cracks(write_network(tmp_path)))
    half = 0.1 * np.sqrt(0.5)
    cracks = network_maps.read_cracks(run, time=0.2)
    assert cracks.lines == pytest.approx(np.array([[[0.5 - half, 0.5 - half], [0.5 + half, 0.5 + half]]]))
    assert list(network_maps.read_cracks(run).mode) == ["I", "II"]


def test_plot_edge_histograms(tmp_path):
    runs = [write_network(tmp_path / f"{k}", seed=k) for k in range(2)]
    done = script("edge_histograms", *runs, "--csv", tmp_path / "edges.csv", "--out", tmp_path / "h")
    check_figures(done, tmp_path / "h")
    assert (tmp_path / "edges.csv").read_text().startswith("run,quantity,edges")


def test_plot_stress(tmp_path):
    done = script("stress", write_network(tmp_path))
    check_figures(done, tmp_path / "figures" / "stress")
    assert "mean stress_xx" in done.stdout


def test_plot_mesh(tmp_path):
    done = script("mesh", write_network(tmp_path))
    check_figures(done, tmp_path / "figures" / "mesh")
    assert "3200 triangles" in done.stdout


def test_plot_history(tmp_path):
    a, b = write_shear(tmp_path / "a"), write_shear(tmp_path / "b", 0.36)
    done = script("history", a, b, "--y", "joint.aperture_mm", "joint.dilation_mm")
    check_figures(done, tmp_path / "figures" / "history_a+b")
    assert not (a / "figures").exists()


SWEEP = """run,joint.law,status,message,seconds,results,slip_mm,k_m2
1,jcm,done,,1,runs/a,0.1,1e-15
2,coulomb,done,,1,runs/b,0.3,1e-13
3,jcm,failed,no mesh,1,runs/c,,
4,jcm,done,,1,runs/d,0.2,
"""


def test_plot_sweep(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(SWEEP)
    done = script("sweep", path, "--by", "joint.law", "--csv", tmp_path / "means.csv")
    check_figures(done, tmp_path / "figures" / "sweep")
    assert "3 runs, 1 more not done or failed" in done.stdout
    with open(tmp_path / "means.csv", newline="") as file:
        found = {(row["column"], row["value"]): row for row in csv.DictReader(file)}
    assert float(found["slip_mm", "jcm"]["mean"]) == pytest.approx(0.15)
    assert found["k_m2", "jcm"]["runs"] == "1"
    for words, said in (
        (["--columns", "nothing"], "no column 'nothing'"),
        (["--by", "law"], "no column 'law'"),
    ):
        assert said in script("sweep", path, *words).stderr


@pytest.mark.parametrize("name", command.names())
def test_every_script_explains_itself(name):
    done = script(name, "--help")
    assert done.returncode == 0
    assert "--out" in done.stdout
