"""Groups of the mesh that a deck names: several of one name, empty ones, and curves that are no fracture.

The mesh is that of scenes/wrong_meshes: three by three squares with a fracture of one line in the middle.
"""

import csv
import importlib.util
import subprocess
from pathlib import Path

import pytest

SCENE = Path(__file__).resolve().parent / "scenes" / "wrong_meshes"
SPECIFICATION = importlib.util.spec_from_file_location("wrong_meshes", SCENE / "wrong_meshes.py")
wrong_meshes = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(wrong_meshes)
LINE = wrong_meshes.LINE

RUN = "&run mesh = 'box.msh', solver = 'implicit' /\n"
ROCK = "&material group = '{}', density = 2700, young = 30e9, poisson = 0 /\n"
JOINT = "&joint group = '{}', law = 'coulomb', friction_angle = 30, kn_mpa_mm = 10, ks_mpa_mm = 1 /\n"
HELD = "&boundary group = '{}', vx = 0, vy = 0 /\n"
TOP = "&boundary group = 'top', pressure = 1e6 /\n"
STAGE = "&stage name = 'load', move_time = 1e-3 /\n"


def with_top(mesh):
    mesh.groups["top"] = (1, 9)
    for x in range(3):
        mesh.add(LINE, 9, mesh.at(x, 3), mesh.at(x + 1, 3))
    return mesh


def run(femdem, mesh, deck, directory, *options):
    (directory / "box.msh").write_text(mesh.text())
    (directory / "deck.nml").write_text(deck)
    command = [femdem, *options, "deck.nml"]
    return subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=60, check=False)


def last_row(directory):
    with open(directory / "results" / "history.csv", newline="", encoding="utf-8") as file:
        return {name: float(value) for name, value in list(csv.DictReader(file))[-1].items()}


@pytest.mark.fast
def test_a_boundary_means_the_curve_where_a_surface_has_its_name(femdem, tmp_path):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.groups = {"bottom": (2, 3), "bottom ": (1, 1), "fracture": (1, 2), "top": (1, 9)}
    deck = RUN + ROCK.format("bottom") + JOINT.format("fracture") + HELD.format("bottom") + TOP + STAGE
    done = run(femdem, mesh, deck, tmp_path)
    assert done.returncode == 0, done.stderr
    # Pressed from above by 1 MPa, 3 m wide and high: p^2/(2 E) times the area, held at the bottom alone
    assert last_row(tmp_path)["strain_J"] == pytest.approx(0.5 * 1e12 / 30e9 * 9, rel=0.02)
    assert "a physical curve and a physical surface of that name; the curve is taken" in done.stderr


@pytest.mark.fast
def test_an_initial_velocity_means_the_surface(femdem, tmp_path):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.groups = {"bottom": (2, 3), "bottom ": (1, 1), "fracture": (1, 2), "top": (1, 9)}
    deck = RUN.replace("implicit", "explicit") + ROCK.format("bottom") + JOINT.format("fracture")
    done = run(femdem, mesh, deck + "&initial group = 'bottom', vy = 2 /\n" + STAGE, tmp_path)
    assert done.returncode == 0, done.stderr
    assert last_row(tmp_path)["kinetic_J"] == pytest.approx(0.5 * 2700 * 9 * 2**2, rel=1e-6)
    assert "the surface is taken" in done.stderr


@pytest.mark.fast
def test_a_pore_pressure_must_say_which(femdem, tmp_path):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.groups = {"frac": (2, 3), "bottom": (1, 1), "frac ": (1, 2), "top": (1, 9)}
    deck = RUN + ROCK.format("frac") + JOINT.format("frac") + HELD.format("bottom") + STAGE
    done = run(femdem, mesh, deck + "&pore_pressure group = 'frac', pressure = 1e6 /\n", tmp_path)
    assert done.returncode == 2
    assert "a physical curve and a physical surface of that name" in done.stderr


@pytest.mark.fast
def test_groups_without_elements_are_errors(femdem, tmp_path):
    mesh = wrong_meshes.Mesh()
    mesh.groups |= {"no rock": (2, 7), "no joint": (1, 8), "no side": (1, 9)}
    strength = "tensile_strength = 7e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500"
    deck = RUN + ROCK.format("rock") + JOINT.format("fracture") + HELD.format("bottom") + STAGE
    deck += ROCK.format("no rock") + JOINT.format("no joint") + HELD.format("no side")
    deck += f"&cohesive group = 'no rock', {strength} /\n&pore_pressure group = 'no joint', pressure = 1 /\n"
    done = run(femdem, mesh, deck, tmp_path, "--check")
    assert done.returncode == 2, done.stderr
    for what in ("&material", "&cohesive"):
        assert f"{what} group = 'no rock': this group of the mesh is empty" in done.stderr
    for what in ("&joint", "&pore_pressure"):
        assert f"{what} group = 'no joint': this group of the mesh is empty" in done.stderr
    assert "&boundary group = 'no side': this group of the mesh is empty" in done.stderr


@pytest.mark.fast
def test_an_inner_curve_without_joint_is_warned_of(femdem, tmp_path):
    deck = RUN + ROCK.format("rock") + HELD.format("bottom") + STAGE
    done = run(femdem, wrong_meshes.Mesh(), deck, tmp_path, "--check")
    assert done.returncode == 0
    assert (
        "1 of the 1 edges of the physical curve 'fracture' lie inside the rock, and no &joint" in done.stderr
    )


@pytest.mark.fast
def test_a_fracture_of_one_element_is_warned_of(femdem, tmp_path):
    deck = RUN + ROCK.format("rock") + JOINT.format("fracture") + HELD.format("bottom") + STAGE
    done = run(femdem, wrong_meshes.Mesh(), deck, tmp_path, "--check")
    assert done.returncode == 0
    assert "1 joint elements of 'fracture' are fractures of one element with both tips" in done.stderr
    longer = wrong_meshes.Mesh()
    longer.add(LINE, 2, longer.at(2, 1), longer.at(2, 2))
    done = run(femdem, longer, deck, tmp_path, "--check")
    assert done.stderr == ""


@pytest.mark.fast
@pytest.mark.parametrize("solver", ["implicit", "explicit", "relaxation"])
def test_a_coulomb_joint_has_the_stiffness_of_its_penalty(solver, femdem, tmp_path):
    """Without kn and ks: the same as with both at penalty over height."""
    mesh = with_top(wrong_meshes.Mesh())
    mesh.add(LINE, 2, mesh.at(0, 1), mesh.at(1, 1))
    mesh.add(LINE, 2, mesh.at(2, 1), mesh.at(3, 1))
    deck = RUN.replace("implicit", solver) + ROCK.format("rock") + HELD.format("bottom") + STAGE
    deck += TOP.replace("pressure = 1e6", "tx = 0.05e6, ty = -1e6")
    joint = "&joint group = 'fracture', law = 'coulomb', friction_angle = 30, {} /\n"
    rows = []
    # Triangles are 0.5 m high: 1e10 Pa over that is 20 MPa/mm
    for stiffness in ("normal = 'penalty', penalty = 1e10", "kn_mpa_mm = 20, ks_mpa_mm = 20"):
        done = run(femdem, mesh, deck + joint.format(stiffness), tmp_path)
        assert done.returncode == 0, done.stderr
        rows.append(last_row(tmp_path))
    for name in ("shear_displacement_mm", "shear_stress_MPa", "closure_mm", "normal_stress_MPa"):
        column = "fracture." + name
        assert rows[0][column] == pytest.approx(rows[1][column], rel=1e-9), name
    assert abs(rows[0]["fracture.shear_displacement_mm"]) > 1e-6


@pytest.mark.fast
@pytest.mark.parametrize("name", ["cohesive", "fracture"])
def test_rock_that_breaks_by_its_name_and_by_its_old_one(name, femdem, tmp_path):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.groups = {"rock": (2, 3), "bottom": (1, 1), "joint": (1, 2), "top": (1, 9)}
    breaks = f"&{name} group = 'rock', tensile_strength = 3e6, cohesion = 8e6, friction_angle = 30, g_i = 50, g_ii = 200 /\n"
    deck = RUN + ROCK.format("rock") + JOINT.format("joint") + HELD.format("bottom") + TOP + STAGE + breaks
    done = run(femdem, mesh, deck, tmp_path)
    assert done.returncode == 0, done.stderr
    assert ("&fracture is called &cohesive now" in done.stderr) == (name == "fracture")
    assert "&cohesive" in (tmp_path / "results" / "deck.nml").read_text()
    assert (tmp_path / "results" / "cracks.csv").exists()
