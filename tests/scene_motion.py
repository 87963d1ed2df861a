"""Motion of the bodies of a scene, from its fields: for the check.py of scenes with a closed form.

motion = Motion(results)
motion.displacement("block", step=-1)     # mean displacement, weighted with mass [m]
motion.momentum(step=0)                   # total momentum [N s per m of thickness]
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "postproc"))
from femdem.results import Results


class Motion:
    """Masses of the bodies (physical surfaces) of a run, and means of its fields over them."""

    def __init__(self, results):
        self.results = Results(results)
        self.fields = self.results.fields
        self.history = self.results.history
        self.mesh = self.fields.mesh()
        self.names = self.mesh.group_name
        density = {material["group"]: material["density"] for material in self.results.deck.all("material")}
        corner = self.mesh.coordinates[self.mesh.triangles]
        a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        self.area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        self.triangle_name = np.array([self.names[group] for group in self.mesh.triangle_group])
        self.triangle_mass = self.area * np.array([density[name] for name in self.triangle_name])

    def nodal_mass(self, body=None):
        """Lumped mass of the nodes, of one body or of all [kg per m of thickness]"""
        mass = np.zeros(len(self.mesh.coordinates))
        for name, third, nodes in zip(
            self.triangle_name, self.triangle_mass / 3, self.mesh.triangles, strict=True
        ):
            if body in (None, name):
                mass[nodes] += third
        return mass

    def mean(self, field, body, step=-1):
        """Mean of a nodal vector over a body, weighted with mass: for displacements that of the centre of mass"""
        mass = self.nodal_mass(body)
        return mass @ self.fields.read(field, step) / mass.sum()

    def displacement(self, body, step=-1):
        return self.mean("displacement", body, step)

    def velocity(self, body, step=-1):
        return self.mean("velocity", body, step)

    def momentum(self, step=-1):
        return self.nodal_mass() @ self.fields.read("velocity", step)

    def stress(self, name, body, step=-1):
        """Values of a stress in the triangles of a body [Pa], compression positive"""
        return self.fields.read(name, step)[self.triangle_name == body]

    def drift(self):
        """Largest part of the energy balance that is not accounted for [J per m of thickness]"""
        return np.abs(self.history["residual_J"]).max()


def run_deck(folder, deck, directory, *arguments, status=0, timeout=300):
    """Run the program under test on another deck of a scene's copy; the results directory."""
    command = [os.environ["FEMDEM"], *arguments, "--output", directory, deck]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=timeout, check=False)
    said = done.stdout + done.stderr
    (Path(folder) / f"{directory}.txt").write_text(said, encoding="utf-8")
    assert done.returncode == status, f"{deck}: status {done.returncode}, expected {status}\n{said[-2000:]}"
    return Path(folder) / directory


def changed_deck(folder, deck, new, *changes):
    """Write a copy of a deck with pieces of text replaced: (old, new) pairs, each old one being there exactly once."""
    text = (Path(folder) / deck).read_text(encoding="utf-8")
    for old, other in changes:
        assert text.count(old) == 1, f"{deck}: '{old}' is there {text.count(old)} times"
        text = text.replace(old, other)
    (Path(folder) / new).write_text(text, encoding="utf-8")
    return new


def output_says(results, *words, never=()):
    """What the run of a scene printed: every word must be in it, none of the others."""
    said = (Path(results).parent / "output.txt").read_text(encoding="utf-8")
    for word in words:
        assert word in said, f"'{word}' is missing in: {said}"
    for word in never:
        assert word not in said, f"'{word}' does not belong in: {said}"
    return said


def near(found, expected, relative, what):
    """Assert a number within a relative tolerance; the message has both."""
    assert abs(found - expected) <= relative * abs(expected), (
        f"{what}: expected {expected:.9g} within {relative:.1e} of it, found {found:.9g} "
        f"({(found - expected) / expected:+.2e})"
    )
    print(f"{what}: expected {expected:.9g}, found {found:.9g} ({(found - expected) / expected:+.2e})")
