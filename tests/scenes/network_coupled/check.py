"""The network of network_three_solvers with walls that ride on their asperities: the cost, and convergence with increments."""

import re
from pathlib import Path

import numpy as np

from femdem.results import Results
from scene_motion import changed_deck, run_deck

COUPLED = ("a0_mm = 0.194", "a0_mm = 0.194, coupling = 'coupled'")
INCREMENTS = 20  # two phases of ten cycles, none of them cut
DEARER = 2.0  # found: 1.2 times the iterations, 1.8 times the factorisations
SAME = 3e-3  # means of the aperture with 10 and with 40 cycles; found 2.3e-3 and 1.2e-3


def work(results):
    """Increments, iterations and factorisations of a run."""
    text = (Path(results) / "run.log").read_text(encoding="utf-8")
    iterations, factorisations = map(int, re.search(r"(\d+) iterations, (\d+) factorisations", text).groups())
    return int(re.search(r"done +(\d+) steps", text).group(1)), iterations, factorisations


def mean_aperture(results, step):
    fields = Results(results).fields
    mesh = fields.mesh()
    length = np.hypot(*(mesh.joint_lines[:, 1] - mesh.joint_lines[:, 0]).T)
    return np.average(fields.read("aperture_mm", step), weights=length)


def check(results):
    folder = Path(results).parent
    _, iterations, factorisations = work(results)
    coupled = run_deck(
        folder, changed_deck(folder, "network.nml", "coupled.nml", COUPLED), "coupled", "--quiet"
    )
    taken = work(coupled)
    print(f"paper: {iterations} iterations, {factorisations} factorisations; coupled: {taken}")
    assert taken[0] == INCREMENTS, f"{taken[0]} increments"
    assert taken[1] <= DEARER * iterations, f"{taken[1]} iterations, {iterations} with coupling = 'paper'"
    assert taken[2] <= DEARER * factorisations, f"{taken[2]} factorisations, {factorisations}"
    text = (folder / "coupled.nml").read_text(encoding="utf-8").replace("cycles = 10,", "cycles = 40,")
    (folder / "fine.nml").write_text(text, encoding="utf-8")
    fine = run_deck(folder, "fine.nml", "fine", "--quiet")
    for step in (0, 1):
        apart = mean_aperture(coupled, step) / mean_aperture(fine, step) - 1
        print(f"phase {step + 1}: mean aperture with 10 cycles {100 * apart:+.3f} % of that with 40")
        assert abs(apart) <= SAME, f"mean aperture {apart:+.2e}"
