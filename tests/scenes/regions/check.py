"""Joints only inside the surface that asks for them, a bar as stiff as rock and joints in series, and a crack there.

Under a uniform stress s along the bar every joint parts by s n/k, k = penalty_factor E/h, and in a grid of squares with one
diagonal each these gaps add up to no misfit round any node. A line along the bar crosses an edge between squares, n = 1, and
a diagonal, its n along the bar 1/sqrt(2), in every square: n columns part by ((n - 1) + n/sqrt(2)) s/k together.
"""

import csv
import math

import numpy as np

from scene_motion import Motion, near

LENGTH, HEIGHT, COLUMNS = 0.3, 0.1, 4
YOUNG, POISSON, STRENGTH, FACTOR = 30e9, 0.2, 7e6, 20.0
LEFT, RIGHT = 0.1, 0.2  # of the surface that breaks
STRETCH = 0.01 * 3.5e-3
RATE = 0.02


def check(results):
    run = Motion(results)
    mesh = run.fields.mesh()
    ends = mesh.joint_lines
    middle = ends.mean(axis=1)[:, 0]
    # Inside a grid of n by n squares: 2 n (n - 1) edges between squares and n^2 diagonals
    assert len(ends) == 2 * COLUMNS * (COLUMNS - 1) + COLUMNS**2, f"{len(ends)} joints"
    assert ((middle > LEFT) & (middle < RIGHT)).all(), "joints outside the surface, or on its border"

    size = HEIGHT / COLUMNS
    joints = ((COLUMNS - 1) + COLUMNS / math.sqrt(2)) * size / (FACTOR * YOUNG)
    expected = STRETCH / (LENGTH * (1 - POISSON**2) / YOUNG + joints)
    stress = -run.fields.read("stress_xx", 0)
    near(stress.mean(), expected, 1e-4, "stress at half the strength")
    assert np.abs(stress - expected).max() < 1e-3 * expected, "the stress is not uniform"

    history = run.history
    time, work = history["time_s"], history["external_J"]
    pull = np.diff(work) / np.diff(time) / (RATE * HEIGHT)
    near(pull[1:].max(), STRENGTH, 0.01, "strength")
    with open(run.results.directory / "cracks.csv", encoding="utf-8") as file:
        cracks = [(float(row["x_m"]), row["mode"]) for row in csv.DictReader(file)]
    assert len(cracks) >= COLUMNS, f"only {len(cracks)} joints have broken"
    assert all(LEFT < x < RIGHT for x, _ in cracks), "something has broken outside the surface"
