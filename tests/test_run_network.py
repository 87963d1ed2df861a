"""femdem-network as a user runs it: nothing old is shown, what fails does not end the rest, loads are what was asked for."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from femdem.network import run_network
from femdem.results import Results

TOP = Path(__file__).resolve().parent.parent
NETWORK = TOP / "input" / "network"

COARSE = ["--size", "0.12", "--models", "jcm", "--cycles", "3", "--no-figures"]
# Far-field stress found in the rock against that applied: fractures and a mesh of few elements bend it [MPa]
CLOSE = 0.02


@pytest.fixture
def network(femdem, tmp_path):
    """Run the script on the traces of two sets in a results directory of the test's own."""

    def run(*options, traces=NETWORK / "two_sets.csv", status=0):
        command = [sys.executable, "-m", "femdem", "network", traces, "--femdem", femdem]
        command += ["--results", tmp_path / "results", *options]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        return done

    run.results = tmp_path / "results"
    return run


def mean_stress(results):
    """Mean of sxx, syy, sxy over the rock, weighted by area, compression positive [MPa]."""
    fields = Results(results).fields
    corner = fields.mesh().coordinates[fields.mesh().triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return [np.average(fields.read(f"stress_{c}"), weights=area) / 1e6 for c in ("xx", "yy", "xy")]


# ---- Nothing old is shown ----


@pytest.mark.fast
def test_other_options_give_other_results(network):
    first = network(*COARSE, "--phase", "load=7,5")
    assert "jcm load: kept" not in first.stdout
    mesh = (network.results / "mesh.msh").read_bytes()
    again = network(*COARSE, "--phase", "load=7,5")
    assert "mesh.msh: kept" in again.stdout
    assert "jcm phase_1: kept" in again.stdout
    assert "jcm load: kept" in again.stdout
    # Size and --cracks as in the command that once showed the first run's answer
    other = network(*COARSE, "--phase", "load=7,5", "--size", "0.1", "--cracks")
    assert "mesh.msh: made now (the command changed)" in other.stdout
    assert "kept" not in other.stdout
    assert (network.results / "mesh.msh").read_bytes() != mesh
    assert "cohesive" in {name for name, _ in Results(network.results / "jcm" / "load").deck.groups}
    assert (network.results / "jcm" / "load" / "cracks.csv").is_file()
    # and back: the cracks of the run before are not this one's
    network(*COARSE, "--phase", "load=7,5", "--size", "0.1")
    assert not (network.results / "jcm" / "load" / "cracks.csv").exists()


def test_only_what_depends_on_a_change_is_made_anew(network):
    network(*COARSE, "--phase", "a=6,5", "--phase", "b=7,5")
    done = network(*COARSE, "--phase", "a=6,5", "--phase", "b=8,5")
    assert "jcm phase_1: kept" in done.stdout
    assert "jcm a: kept" in done.stdout
    assert "(deck changed)" in done.stdout.partition("jcm b:")[2]
    done = network(*COARSE, "--phase", "a=6,5", "--stress", "4", "4")
    assert "(deck, phase I changed)" in done.stdout.partition("jcm a:")[2]


def test_other_traces_of_the_same_name_are_seen(network, tmp_path):
    traces = tmp_path / "map.csv"
    traces.write_text("x1,y1,x2,y2,trace\n0,0,1,1,0\n0,1,1,0,1\n")
    options = [*COARSE, "--phase", "a=6,5"]
    network(*options, traces=traces)
    traces.write_text("x1,y1,x2,y2,trace\n0,0,1,1,0\n0,0.8,1,0.3,1\n")
    done = network(*options, traces=traces)
    assert (
        "made now (map.csv, mesh.txt changed)" in done.stdout or "made now (map.csv changed)" in done.stdout
    )
    assert "kept" not in done.stdout


def test_results_of_another_mesh_are_named(network):
    network(*COARSE, "--models", "jcm", "coulomb", "--phase", "a=6,5")
    done = network(*COARSE, "--phase", "a=6,5", "--size", "0.1")
    assert "of another mesh than this one, from earlier commands: coulomb/a, coulomb/phase_1" in done.stdout


# ---- It survives ----


@pytest.mark.fast
def test_a_phase_that_fails_ends_neither_the_others_nor_the_figures(network):
    # Rock in blocks, pulled apart: nothing holds it
    options = [word for word in COARSE if word != "--no-figures"]
    figures = network.results / "figures"
    figures.mkdir(parents=True)
    for name in ("models", "failed_jcm_older"):
        (figures / f"{name}.png").write_text("of an earlier run")
    done = network(*options, "--phase", "pull=-20,-20", "--phase", "load=6,5", status=1)
    assert "jcm pull: FAILED" in done.stdout
    assert Results(network.results / "jcm" / "load").fields.stages == ["load"]
    assert "2 of 3 runs done; failed:" in done.stderr
    assert "  jcm pull: no rest" in done.stderr
    for name in ("network", "edge_histograms", "stress", "displacement", "failed_jcm_pull"):
        assert (figures / f"{name}.png").is_file(), name
    for name in ("models", "failed_jcm_older"):
        assert not (figures / f"{name}.png").exists(), name
    # It is not taken for done the next time
    assert "jcm pull: FAILED" in network(*COARSE, "--phase", "pull=-20,-20", status=1).stdout


def test_phases_are_left_out_where_phase_1_fails(network):
    done = network(
        *COARSE, "--models", "jcm", "coulomb", "--phase", "phase_1=-20,-20", "--phase", "a=6,5", status=1
    )
    assert "0 of 4 runs done" in done.stderr
    assert "  jcm a: left out: phase I" in done.stderr
    assert "  coulomb a: left out: phase I" in done.stderr


def test_a_program_that_dies_is_said(network, tmp_path):
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\nkill -9 $$\n")
    program.chmod(0o755)
    done = network(*COARSE, "--phase", "a=6,5", "--femdem", program, status=1)
    assert "jcm phase_1: ended by signal 9" in done.stderr


WRONG = {
    "traces": (["--size", "0.1"], "none.csv: there is no such file"),
    "size": (["--size", "-1"], "--size -1"),
    "phase": (["--phase", "a=1"], "--phase a=1"),
    "angle": (["--phase", "a=1,2,3@4"], "--phase a=1,2,3@4"),
    "twice": (["--phase", "a=1,2", "--phase", "a=2,3"], "'a' is given twice"),
    "name": (["--phase", "all=1,2"], "'all' is no name"),
    "shear on rollers": (["--rollers", "--phase", "turned=8,5@30"], "cannot act on rollers"),
    "pressure": (["--pore-pressure=-1"], "--pore-pressure -1"),
    "phase of a pressure": (
        ["--pore-pressure", "z=1"],
        "there is no phase 'z'; there are: phase_1, phase_2a",
    ),
    "biot": (["--biot", "2"], "--biot 2"),
    "deck": (["--deck", "none.nml"], "none.nml: there is no such file"),
    "program": (["--femdem", "none"], "none: there is no such file"),
}


@pytest.mark.fast
def test_all_that_is_wrong_is_said_at_once(network):
    options = [word for words, _ in WRONG.values() for word in words]
    done = network(*options, traces="none.csv", status=2)
    for _, said in WRONG.values():
        # where a name is given, the phases are others
        assert said.partition("; there are")[0] in done.stderr
    assert all(line.startswith("error: ") for line in done.stderr.splitlines())


@pytest.mark.fast
@pytest.mark.parametrize("what", [name for name in WRONG if name != "traces"])
def test_each_wrong_option_is_refused(what, network):
    assert WRONG[what][1] in network(*WRONG[what][0], status=2).stderr


@pytest.mark.fast
def test_a_deck_that_cannot_be_changed_is_refused(network, tmp_path):
    text = (NETWORK / "phase_1.nml").read_text().replace("law = 'jcm'", "law = 'coulomb'")
    (tmp_path / "my.nml").write_text(text)
    assert "law = 'jcm' is there 0 times" in network("--deck", tmp_path / "my.nml", status=2).stderr


@pytest.mark.fast
def test_a_window_without_a_trace_is_refused(network):
    done = network(*COARSE, "--window", "5", "5", "6", "6", status=2)
    assert "no trace lies in the window" in done.stderr
    assert "nothing was run" in done.stderr


# ---- Loads ----


@pytest.mark.fast
def test_principal_stresses_are_turned():
    stress = run_network.Stress.principal(10.0, 4.0, 30.0)
    tensor = np.array([[stress.sxx, stress.sxy], [stress.sxy, stress.syy]])
    along = np.array([np.cos(np.radians(30)), np.sin(np.radians(30))])
    assert tensor @ along == pytest.approx(10.0 * along, rel=1e-14)
    assert np.trace(tensor) == pytest.approx(14.0, rel=1e-14)


@pytest.mark.fast
def test_turned_and_shear_stresses_act_on_the_rock(network):
    network(*COARSE, "--phase", "phase_1=8,5@30", "--phase", "shear=6,6,-1")
    expected = run_network.Stress.principal(8.0, 5.0, 30.0)
    found = mean_stress(network.results / "jcm" / "phase_1")
    assert found == pytest.approx([expected.sxx, expected.syy, expected.sxy], abs=CLOSE)
    assert mean_stress(network.results / "jcm" / "shear") == pytest.approx([6.0, 6.0, -1.0], abs=CLOSE)
    fields = Results(network.results / "jcm" / "phase_1").fields
    # The direction in the results is measured as --phase measures it; the median leaves out what fractures turn
    assert np.median(fields.read("stress_1_angle_deg")) == pytest.approx(30.0, abs=3.0)


def side_motion(results):
    """Displacements of the four sides across them: left, right, bottom, top (least, largest) [mm]."""
    fields = Results(results).fields
    mesh, moved = fields.mesh(), 1e3 * fields.read("displacement")
    # By the edges on the sides: a corner of rock between two fractures that only touches a side is not held
    edges = mesh.surface[mesh.surface_joint < 0]
    found = []
    for axis, end in ((0, 0.0), (0, 2.0), (1, 0.0), (1, 2.0)):
        on_side = (np.abs(mesh.coordinates[edges][:, :, axis] - end) < 1e-9).all(axis=1)
        across = moved[edges[on_side].ravel(), axis]
        found += [across.min(), across.max()]
    return found


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["implicit", "relaxation"])
def test_displacements_drive_the_sides(network, solver):
    network(*COARSE, "--phase", "phase_1=0.2,0mm", "--phase", "more=0.1,-0.05mm", "--solver", solver)
    first = side_motion(network.results / "jcm" / "phase_1")
    assert first == pytest.approx([0, 0, -0.2, -0.2, 0, 0, 0, 0], abs=1e-9)
    more = side_motion(network.results / "jcm" / "more")
    assert more == pytest.approx([0, 0, -0.3, -0.3, 0, 0, 0.05, 0.05], abs=1e-9)
    sxx, syy, _ = mean_stress(network.results / "jcm" / "more")
    assert sxx > syy > 0.0


@pytest.mark.fast
def test_rollers_hold_left_and_bottom(network):
    network(*COARSE, "--rollers", "--phase", "load=8,5")
    left = side_motion(network.results / "jcm" / "load")
    assert [left[k] for k in (0, 1, 4, 5)] == [0.0] * 4
    assert mean_stress(network.results / "jcm" / "load")[:2] == pytest.approx([8.0, 5.0], abs=0.3)


@pytest.mark.fast
def test_pore_pressure_relieves_the_rock(network):
    network(
        *COARSE, "--phase", "wet=8,6", "--pore-pressure", "1", "--pore-pressure", "wet=3", "--biot", "0.5"
    )
    # Effective stress: total less Biot coefficient times pressure, up to the pressure at the fractures
    assert mean_stress(network.results / "jcm" / "phase_1")[:2] == pytest.approx([4.5, 4.5], abs=0.1)
    found = mean_stress(network.results / "jcm" / "wet")
    assert found[:2] == pytest.approx([6.5, 4.5], abs=0.3)


def test_the_solver_is_the_one_asked_for(network):
    solvers = {"relaxation": "relaxation", "auto": "implicit"}
    for asked, taken in solvers.items():
        network(*COARSE, "--phase", "a=6,5", "--solver", asked)
        assert Results(network.results / "jcm" / "a").deck.all("run")[0]["solver"] == taken


def test_the_window_goes_to_the_mesh(network):
    network(*COARSE, "--phase", "a=6,5", "--window", "0.5", "0.5", "1.5", "1.25", "--size", "0.06")
    place = Results(network.results / "jcm" / "a").fields.mesh().coordinates
    assert [*place.min(axis=0), *place.max(axis=0)] == pytest.approx([0.5, 0.5, 1.5, 1.25])


@pytest.mark.fast
def test_a_hole_and_a_zone_go_to_the_mesh(network, tmp_path):
    text = (NETWORK / "phase_1.nml").read_text()
    soft = "&material group = 'soft', density = 2700, young = 10e9, poisson = 0.27 /\n"
    (tmp_path / "my.nml").write_text(text + soft)
    # One trace, far from the hole: blocks between several would fall into it
    (tmp_path / "map.csv").write_text("x1,y1,x2,y2,trace\n0.2,0.2,0.9,0.3,0\n")
    options = ["--deck", tmp_path / "my.nml", "--window", "0", "0", "2", "2", "--hole", "1.3", "1.3", "0.2"]
    options += ["--zone", "0,0 2,0 2,0.5 0,0.5", "soft", "--phase", "load=6,5"]
    network(*COARSE, *options, traces=tmp_path / "map.csv")
    fields = Results(network.results / "jcm" / "load").fields
    mesh = fields.mesh()
    assert {"rock", "soft"} <= set(mesh.group_name)
    centre = mesh.coordinates[mesh.triangles].mean(axis=1)
    assert (np.hypot(*(centre - 1.3).T) > 0.19).all()
    soft = np.array(mesh.group_name)[mesh.triangle_group] == "soft"
    assert (soft == (centre[:, 1] < 0.5)).all()


def test_a_zone_without_material_is_said(network):
    done = network(*COARSE, "--zone", "0,0 2,0 2,0.5 0,0.5", "soft", "--phase", "a=6,5", status=1)
    assert "jcm phase_1: " in done.stderr.partition("failed:")[2]
    assert "soft" in done.stderr


def test_lost_length_is_warned_of_again_when_the_mesh_is_kept(network):
    for _ in range(2):
        done = network(*COARSE, "--phase", "a=6,5")
        assert done.stderr.count("warning: cleaning lost") == 1
