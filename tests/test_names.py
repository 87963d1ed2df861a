"""Names with signs that mean something in tables come back from every file; joints say the numbers of their own law."""

import csv

import pytest

from femdem.results import Results
from test_groups import HELD, ROCK, RUN, run, with_top, wrong_meshes

ODD = ["a, b", "c; d", '5" e', "it's", "a.shear_displacement_mm"]


def two_joints(first, second):
    mesh = with_top(wrong_meshes.Mesh())
    mesh.groups = {"rock": (2, 3), "bottom": (1, 1), first: (1, 2), "top": (1, 9), second: (1, 8)}
    mesh.add(wrong_meshes.LINE, 2, mesh.at(2, 1), mesh.at(3, 1))
    for x in range(2):
        mesh.add(wrong_meshes.LINE, 8, mesh.at(x, 2), mesh.at(x + 1, 2))
    return mesh


def in_deck(name):
    return name.replace("'", "''")


@pytest.mark.fast
@pytest.mark.parametrize("name", ODD)
def test_names_come_back(name, femdem, tmp_path):
    # gmsh cannot have a double quote in a name: a stage can
    joint = name.replace('"', "''")
    mesh = two_joints(joint, "second")
    law = "law = 'coulomb', friction_angle = 30, kn_mpa_mm = 10, ks_mpa_mm = 1"
    deck = RUN.replace("implicit", "explicit") + ROCK.format("rock") + HELD.format("bottom")
    deck += f"&joint group = '{in_deck(joint)}', {law} /\n&joint group = 'second', {law} /\n"
    deck += f"&stage name = '{in_deck(name)}', move_time = 5e-3 /\n&boundary group = 'top', vy = 0.5 /\n"
    deck += "&cohesive group = 'rock', insertion = 'everywhere', tensile_strength = 0.3e6, cohesion = 15e6, "
    deck += "friction_angle = 26.6, g_i = 100, g_ii = 500 /\n"
    done = run(femdem, mesh, deck, tmp_path)
    assert done.returncode == 0, done.stderr
    results = Results(tmp_path / "results")
    assert results.history.groups == [joint, "second"]
    assert len(results.history.joint(joint, "shear_displacement_mm")) == 1
    assert sorted(set(results.edges.group)) == sorted([joint, "second"])
    assert results.fields.stages == [name]
    assert joint in results.fields.mesh().group_name
    assert results.deck.joint(joint)["kn_mpa_mm"] == 10
    with open(tmp_path / "results" / "cracks.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["stage"] for row in rows} == {name}, "nothing broke, or the stage has another name"
    # Goes on with its own tables
    more = deck + "&stage name = 'more', move_time = 1e-3 /\n"
    done = run(femdem, mesh, more, tmp_path, "--branch", "results/checkpoint.h5")
    assert done.returncode == 0, done.stderr
    assert len(Results(tmp_path / "results").history) == 2


@pytest.mark.fast
def test_joints_say_the_numbers_of_their_law(femdem, tmp_path):
    deck = RUN + ROCK.format("rock") + HELD.format("bottom") + "&stage name = 'load', move_time = 1 /\n"
    deck += "&joint group = 'plain', law = 'coulomb', friction_angle = 33, cohesion = 2e5, kn_mpa_mm = 7, ks_mpa_mm = 3 /\n"
    deck += "&joint group = 'rough', jrc0 = 8, jcs0_mpa = 100, l0 = 2, phi_r = 29 /\n"
    done = run(femdem, two_joints("plain", "rough"), deck, tmp_path)
    assert done.returncode == 0, done.stderr
    fields = Results(tmp_path / "results").fields
    mesh = fields.mesh()
    plain = mesh.joint_group == list(mesh.group_name).index("plain")
    expected = {
        "effective_length": (2, 2),
        "jrcn": (0, 8),
        "jcsn_MPa": (0, 100),
        "friction_angle_deg": (33, 29),
        "cohesion_MPa": (0.2, 0),
        "kn_MPa_mm": (7, None),
        "ks_MPa_mm": (3, 0),
    }
    for name, (on_plain, on_rough) in expected.items():
        value = fields.read(name)
        assert value[plain] == pytest.approx(on_plain), name
        if on_rough is not None:
            assert value[~plain] == pytest.approx(on_rough), name
