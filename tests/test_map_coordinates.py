"""A mesh in map coordinates gives the answer it gives at the origin, and what is written is in map coordinates."""

import csv

import numpy as np
import pytest

from femdem.results import Results
from test_groups import HELD, JOINT, ROCK, RUN, STAGE, TOP, run, with_top, wrong_meshes

# An outcrop in Finland, and as far as is promised
PLACES = [(384000.0, 6672000.0), (1e7, -1e7)]
TOLERANCE = 1e-9
STRENGTH = "tensile_strength = 0.3e6, cohesion = 15e6, friction_angle = 26.6, g_i = 100, g_ii = 500"


def mesh_at(place):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.add(wrong_meshes.LINE, 2, mesh.at(2, 1), mesh.at(3, 1))
    mesh.nodes = [(x + place[0], y + place[1]) for x, y in mesh.nodes]
    return mesh


def history(directory):
    with open(directory / "results" / "history.csv", newline="", encoding="utf-8") as file:
        return {name: float(value) for name, value in list(csv.DictReader(file))[-1].items()}


def go(femdem, deck, place, directory, *options):
    directory.mkdir(exist_ok=True)
    done = run(femdem, mesh_at(place), deck, directory, *options)
    assert done.returncode == 0, done.stderr
    return directory


def assert_same(there, origin):
    here, expected = history(there), history(origin)
    work = expected["external_J"]
    for name, value in expected.items():
        # Energies are rounded as their sum is; the rest is what iterations leave over
        scale = work if name.endswith("_J") else abs(value)
        if name not in ("unbalanced_ratio", "residual_J"):
            assert abs(here[name] - value) <= TOLERANCE * scale, (
                f"{name}: {here[name]!r}, at the origin {value!r}"
            )


@pytest.mark.fast
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("solver", ["implicit", "relaxation", "explicit"])
def test_the_answer_is_that_at_the_origin(solver, place, femdem, tmp_path):
    deck = (
        RUN.replace("implicit", solver)
        + ROCK.format("rock")
        + JOINT.format("fracture")
        + HELD.format("bottom")
    )
    deck += TOP + STAGE
    more = (
        deck + STAGE.replace("load", "more") + "&boundary group = 'top', stage = 'more', pressure = 2e6 /\n"
    )
    origin = go(femdem, deck, (0, 0), tmp_path / "origin")
    there = go(femdem, deck, place, tmp_path / "there")
    assert_same(there, origin)
    # Goes on from its checkpoint
    go(femdem, more, (0, 0), origin, "--branch", "results/checkpoint.h5")
    go(femdem, more, place, there, "--branch", "results/checkpoint.h5")
    assert_same(there, origin)
    moved = Results(there / "results").fields.mesh().coordinates - place
    assert np.abs(moved - Results(origin / "results").fields.mesh().coordinates).max() <= 1e-8


@pytest.mark.fast
def test_cracks_are_where_the_map_has_them(femdem, tmp_path):
    deck = RUN.replace("implicit", "explicit") + ROCK.format("rock") + HELD.format("bottom")
    deck += f"&cohesive group = 'rock', insertion = 'everywhere', {STRENGTH} /\n"
    deck += "&boundary group = 'top', vy = 0.5 /\n&stage name = 'pull', move_time = 5e-3 /\n"
    places = []
    for place in ((0, 0), *PLACES):
        there = go(femdem, deck, place, tmp_path / str(place[0]))
        with open(there / "results" / "cracks.csv", newline="", encoding="utf-8") as file:
            rows = [
                (float(row["x_m"]) - place[0], float(row["y_m"]) - place[1]) for row in csv.DictReader(file)
            ]
        assert rows, "nothing broke"
        places.append(rows)
    assert np.abs(np.array(places[1]) - places[0]).max() < 1e-8
    assert np.abs(np.array(places[2]) - places[0]).max() < 1e-8


@pytest.mark.fast
def test_messages_name_places_of_the_map(femdem, tmp_path):
    mesh = mesh_at(PLACES[0])
    last = max(i for i, (kind, *_) in enumerate(mesh.elements) if kind == wrong_meshes.TRIANGLE)
    mesh.elements[last] = (wrong_meshes.TRIANGLE, 0, mesh.elements[last][2])
    deck = RUN + ROCK.format("rock") + HELD.format("bottom") + STAGE
    done = run(femdem, mesh, deck, tmp_path, "--check")
    assert "triangle 36 at (384002.16667, 6672002.50000) is not in a physical surface" in done.stderr
