"""Results directories made from the empirical law, as a run would write them: what the figure scripts are tested on."""

import csv
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "postproc"))
from femdem.jcm import Joint

DECK = """&run
   title = 'Shear of a {cm:g} cm joint'   ! with a comment
   solver = 'explicit'
/

&material
   group = 'rock',
   density = 1850.0, young = 0.8E+09,
/

&joint
   group = 'joint',
   law = 'jcm',
   jrc0 = 15.0,
   jcs0_mpa = 2.0,
   ! sigma_c_mpa is not given: jcs0_mpa
   l0 = 0.06,
   phi_r = 32.0,
   peak = 'eq15',
   post_peak = 'table',
/
"""
COLUMNS = [
    "time_s", "step", "stage", "cycle", "kinetic_J", "strain_J", "contact_J", "friction_J", "damping_J",
    "external_J", "residual_J", "unbalanced_ratio",
    "joint.shear_displacement_mm", "joint.shear_stress_MPa", "joint.normal_stress_MPa", "joint.dilation_mm",
    "joint.closure_mm", "joint.aperture_mm",
]  # fmt: skip
EDGE_COLUMNS = [
    "id", "group", "joints", "length_m", "mean_shear_displacement_mm", "largest_shear_displacement_mm",
    "mean_aperture_mm", "largest_aperture_mm",
]  # fmt: skip
NORMAL_STRESS = 0.0245  # MPa


def cast_joint(length):
    """The paper's cast joint"""
    return Joint(jrc0=15, jcs0=2, l0=0.06, phi_r=32, length=length)


def write_table(path, heading, rows):
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([heading, *rows])


def write_shear(directory, length=0.06, relative_error=0.0, direction=1.0):
    """A direct shear test to 5 mm; stresses and dilation are wrong by a given part of the peak."""
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    law = cast_joint(length)
    (directory / "deck.nml").write_text(DECK.format(cm=100 * length), encoding="utf-8")
    rows = []
    path = np.concatenate([[0, 0], np.arange(1, 501) * 0.01])
    for i, (u, dilation) in enumerate(zip(path, law.dilation(path, NORMAL_STRESS), strict=True)):
        wrong = relative_error * np.sin(3 * u)
        tau = law.shear_stress(u, NORMAL_STRESS) + wrong * law.peak_shear_stress(NORMAL_STRESS)
        work = 30 * u * length
        energies = work * np.array([0.001, 0.2, 0.05, 0.7, 0.049, 1.0, 1e-5])
        joint = [direction * u, direction * tau, NORMAL_STRESS, dilation, float(law.closure(NORMAL_STRESS))]
        rows.append([0.01 * i, 1000 * i, 1 + (i > 1), i, *energies, 1e-4, *joint, 0.3 + 0.2 * u])
    write_table(directory / "history.csv", COLUMNS, rows)
    write_table(directory / "edges.csv", EDGE_COLUMNS, [[1, "joint", 40, length, 5.0, 5.0, 1.2, 1.2]])
    return directory


def write_closure(directory, length=0.06, relative_error=0.0):
    """A closure test to 1 MPa"""
    directory = write_shear(directory, length)
    law = cast_joint(length)
    rows = [
        [
            0.1 * i,
            i,
            1,
            i,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            s,
            0,
            float(law.closure(s)) * (1 + relative_error),
            0.2,
        ]
        for i, s in enumerate(np.linspace(0, 1, 21))
    ]
    write_table(directory / "history.csv", COLUMNS, rows)
    return directory


def write_network(directory, cells=40, seed=1):
    """A square of 2 m with fractures along grid lines: mesh, two snapshots and all kinds of fields"""
    directory = write_shear(directory)
    chance = np.random.default_rng(seed)
    n = cells + 1
    x, y = np.meshgrid(np.linspace(0, 2, n), np.linspace(0, 2, n))
    nodes = np.column_stack([x.ravel(), y.ravel()])
    inner = (x > 0) & (x < 2) & (y > 0) & (y < 2)
    nodes[inner.ravel()] += chance.uniform(-0.2, 0.2, (inner.sum(), 2)) * 2 / cells
    corner = (np.arange(cells)[:, None] * n + np.arange(cells)).ravel()
    triangles = np.concatenate(
        [
            np.column_stack([corner, corner + 1, corner + n + 1]),
            np.column_stack([corner, corner + n + 1, corner + n]),
        ]
    )
    joints, group, edge = [], [], []
    for k in range(12):
        row, start = chance.integers(3, cells - 3), chance.integers(0, cells // 2)
        for i in range(start, start + cells // 3):
            a, b = (row * n + i, row * n + i + 1) if k % 2 else (i * n + row, (i + 1) * n + row)
            joints.append([a, b, a, b])
            group.append(1 + k % 2)
            edge.append(k + 1)
    joints = np.array(joints)
    side = np.arange(cells)
    surface = np.concatenate(
        [
            np.column_stack([side, side + 1]),
            np.column_stack([side * n + cells, (side + 1) * n + cells]),
            np.column_stack([(cells - side) + cells * n, (cells - side - 1) + cells * n]),
            np.column_stack([(cells - side) * n, (cells - side - 1) * n]),
        ]
    )
    with h5py.File(directory / "fields.h5", "w") as file:
        for name in ("version", "commit", "compiler", "command", "deck", "date"):
            file.attrs[name] = f"some {name}"

        def put(path, values, unit, description, place=None):
            dataset = file.create_dataset(path, data=values)
            dataset.attrs["unit"], dataset.attrs["description"] = unit, description
            if place:
                dataset.attrs["place"] = place
                dataset.attrs["components"] = 1 if np.ndim(values) == 1 else np.shape(values)[1]

        put("mesh/coordinates", nodes, "m", "nodes")
        put("mesh/triangles", triangles, "1", "triangles")
        put("mesh/triangle_group", np.zeros(len(triangles), int), "1", "groups")
        put("mesh/joints", joints, "1", "joints")
        put("mesh/joint_group", np.array(group), "1", "groups")
        put("mesh/block_edge", np.array(edge), "1", "edges")
        put("mesh/surface", surface, "1", "surface")
        put("mesh/surface_joint", np.full(len(surface), -1), "1", "joints")
        put("mesh/group_name", np.array(["rock", "set one", "set two"], dtype=object), "1", "names")
        put("mesh/jrcn", np.linspace(9, 15, len(joints)), "1", "JRCn of eq 8", "joints")
        centre = nodes[triangles].mean(axis=1)
        for i in (1, 2):
            step = f"step_{i:06d}/"
            file.create_group(step).attrs.update({"time_s": 0.1 * i, "step": 100 * i, "stage": "phase I"})
            file[step].attrs.update({"cycle": i, "mesh": "/mesh"})
            u = np.column_stack([1e-4 * i * nodes[:, 1], -2e-4 * i * nodes[:, 1], np.zeros(n * n)])
            put(step + "displacement", u, "m", "displacement", "nodes")
            stress = 5e6 * i * (1 + 0.3 * np.sin(4 * centre[:, 0]) * np.cos(3 * centre[:, 1]))
            put(step + "stress_1", stress, "Pa", "largest compression", "triangles")
            for name, share in (
                ("stress_3", 0.4),
                ("stress_xx", 0.9),
                ("stress_yy", 0.5),
                ("stress_xy", 0.1),
            ):
                put(step + name, share * stress, "Pa", f"some {name}", "triangles")
            put(step + "stress_1_angle_deg", 20 * np.sin(centre[:, 0]), "degrees", "direction", "triangles")
            slip = i * np.sin(np.arange(len(joints)) / 13.0 * np.pi) * np.array(edge) / 12
            put(step + "shear_displacement_mm", slip, "mm", "shear displacement", "joints")
            put(step + "aperture_mm", 0.1 + 0.4 * np.abs(slip), "mm", "aperture", "joints")
    return directory
