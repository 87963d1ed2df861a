#!/usr/bin/env python3
"""What an absorbing side sends back of a wave that meets it at an angle, measured and by the closed form.

    bin/python3 tests/absorbing.py --angles 0 15 30 45 60 --size 0.02 --out absorbing.csv --figure absorbing.png

A plane wave runs along x in a block whose right side leans (scenes/_meshes/tilted.py) and absorbs. The velocity of that side
where no wave of its corners has come yet is that of the wave times (e + R_P e_P + R_S e_S), e being the directions in which the
wave and what is sent back of it move the rock: both R follow from its two components. P waves at any angle, S waves below the
critical one (35 degrees here), beyond which the side lags behind the wave.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "postproc"))
from femdem.figures import style  # noqa: E402
from femdem.results import Fields  # noqa: E402

DENSITY, YOUNG, POISSON = 2500.0, 1e9, 0.25
#: Where the side is looked at, of its height from below: no wave of a corner is there sooner than 0.3 heights after the first one
LOOK = 0.85
#: Length of the wave, of the height of the block
PULSE = 0.28


def speeds():
    """Of P and S waves [m/s]."""
    modulus = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
    return np.sqrt(modulus / DENSITY), np.sqrt(0.5 * YOUNG / (1 + POISSON) / DENSITY)


def directions(kind, angle):
    """Directions of motion of the wave and of the P and S wave that is sent back (3, 2) along the outward normal and the side, with
    their slownesses along the normal (3) and the side, in units of 1/cp; complex beyond the critical angle."""
    cs = speeds()[1] / speeds()[0]
    along = np.sin(np.radians(angle)) * (1.0 if kind == "P" else 1 / cs)
    p, s = np.sqrt(complex(1 - along**2)), np.sqrt(complex(1 / cs**2 - along**2))
    wave = (p, along) if kind == "P" else (-along * cs, s * cs)
    return (
        np.array([wave, (-p, along), (along * cs, s * cs)]),
        np.array([p if kind == "P" else s, -p, -s]),
        along,
    )


def closed_form(kind, angle):
    """Velocity of the P and S wave that is sent back over that of the wave (Lysmer & Kuhlemeyer 1969)."""
    ratio = (speeds()[1] / speeds()[0]) ** 2
    moves, normal, along = directions(kind, angle)
    n, t = moves.T
    # Traction on the side plus that of the dashpots, in units of rho cp v
    across = -(normal * n + (1 - 2 * ratio) * along * t) + n
    shear = -ratio * (normal * t + along * n) + np.sqrt(ratio) * t
    return np.linalg.solve(np.array([across[1:], shear[1:]]), -np.array([across[0], shear[0]]))


def deck(kind, length, frames, more=""):
    """A wave along x that is PULSE long, seen in `frames` snapshots while it passes the side at LOOK."""
    speed = speeds()[0 if kind == "P" else 1]
    half, (held, push) = 0.5 * PULSE / speed, ("vy", "tx") if kind == "P" else ("vx", "ty")
    text = "&run mesh = 'scene.msh', solver = 'explicit' /\n"
    text += f"&material group = 'rock', density = {DENSITY}, young = {YOUNG}, poisson = {POISSON} /\n"
    text += "".join(f"&boundary group = '{side}', {held} = 0 /\n" for side in ("bottom", "top"))
    text += f"&boundary group = 'left', stage = 'up', {push} = 1e5 /\n"
    text += f"&boundary group = 'left', stage = 'down', {push} = 0 /\n"
    text += "&boundary group = 'right', absorbing = .true. /\n" + more
    text += "".join(f"&stage name = '{name}', move_time = {half!r} /\n" for name in ("up", "down"))
    text += f"&stage name = 'way', move_time = {length / speed - 2 * half!r}, profile = 'constant' /\n"
    step = PULSE / speed / frames
    return (
        text
        + f"&stage name = 'pass', move_time = {step!r}, cycles = {frames}, profile = 'constant' /\n&output fields_every = 1 /\n"
    )


def incident(kind, time):
    """Velocity of the wave at its source [m/s]."""
    speed = speeds()[0 if kind == "P" else 1]
    part = time / (0.5 * PULSE / speed)

    def ramp(s):
        s = np.clip(s, 0.0, 1.0)
        return s - np.sin(2 * np.pi * s) / (2 * np.pi)

    return 1e5 / (DENSITY * speed) * (ramp(part) - ramp(part - 1.0))


def measure(program, folder, kind, angle, size, frames=40):
    """R_P and R_S from a run."""
    length = PULSE + 0.05
    mesh = [sys.executable, HERE / "scenes" / "_meshes" / "tilted.py", "--out", folder / "scene.msh"]
    subprocess.run([*mesh, "--angle", str(angle), "--length", str(length), "--size", str(size)], check=True)
    lean = np.tan(np.radians(angle))
    (folder / "deck.nml").write_text(deck(kind, length + LOOK * lean, frames), encoding="utf-8")
    command = [program, "--quiet", "--output", folder / "out", folder / "deck.nml"]
    subprocess.run(command, check=True, capture_output=True)
    fields = Fields(folder / "out" / "fields.h5")
    nodes = fields.mesh().coordinates
    node = np.argmin(np.hypot(nodes[:, 0] - length - LOOK * lean, nodes[:, 1] - LOOK))
    velocity = np.array([fields.read("velocity", step)[node, :2] for step in range(3, 3 + frames)])
    time = np.array(fields.times[3 : 3 + frames])
    wave = incident(kind, time - nodes[node, 0] / speeds()[0 if kind == "P" else 1])
    moves = directions(kind, angle)[0].real
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    # Outward normal (c, -s), along the side upwards (s, c); a P wave meets it with its motion along x
    total = np.array([[c, -s], [s, c]]) @ (wave @ velocity / (wave @ wave))
    if kind == "S":
        total = total * np.sign(moves[0] @ total)
    return np.linalg.solve(moves[1:].T, total - moves[0])


def sent_back(kind, angle):
    """Part of the energy of the wave that is sent back: what its waves carry away from the side."""
    normal = directions(kind, angle)[1]
    speed = np.array([1.0, speeds()[1] / speeds()[0]])
    carried = np.abs(closed_form(kind, angle)) ** 2 * np.abs(normal[1:].real) * speed**2
    return float(carried.sum() / (normal[0].real * speed[0 if kind == "P" else 1] ** 2))


def draw(rows, out):
    """Curves of the closed form, points of the runs; one panel a kind of wave."""
    figure, panels = plt.subplots(
        1, 2, figsize=(170 * style.MM, 75 * style.MM), layout="constrained", sharey=True
    )
    angles = np.linspace(0, 75, 301)
    for kind, axes in zip("PS", panels, strict=True):
        curves = 100 * np.abs([closed_form(kind, angle) for angle in angles])
        part = [row for row in rows if row[0] == kind]
        for index, back in enumerate("PS"):
            style.numeric(axes, angles, curves[:, index], index, f"{back} wave, closed form")
            points = [100 * abs(row[2 + 2 * index]) for row in part]
            style.empirical(axes, [row[1] for row in part], points, index, f"{back} wave, run")
        axes.set(
            title=f"{kind} wave meets the side",
            xlabel="Angle to the normal [degrees]",
            xlim=(-2, 76),
            ylim=(-1, 60),
        )
    panels[0].set_ylabel("Sent back, of the velocity [%]")
    panels[0].legend()
    style.save(figure, out, None, None)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--angles", type=float, nargs="+", default=[0, 15, 30, 45, 60], help="[degrees]")
    parser.add_argument("--size", type=float, default=0.01, help="of the elements; the wave is 0.28 long")
    parser.add_argument("--program", default=os.environ.get("FEMDEM", HERE.parent / "build" / "femdem"))
    parser.add_argument("--out", help="table [CSV]")
    parser.add_argument("--figure", help="figure, without suffix")
    given = parser.parse_args()
    rows = []
    for kind in "PS":
        critical = 90 if kind == "P" else np.degrees(np.arcsin(speeds()[1] / speeds()[0]))
        for angle in (angle for angle in given.angles if angle < critical):
            with tempfile.TemporaryDirectory() as folder:
                found = measure(given.program, Path(folder), kind, angle, given.size)
            exact = closed_form(kind, angle).real
            rows.append(
                [
                    kind,
                    angle,
                    *(float(v) for pair in zip(found, exact, strict=True) for v in pair),
                    sent_back(kind, angle),
                ]
            )
    style.error_table(
        ["wave", "angle", "P_run", "P_exact", "S_run", "S_exact", "energy_exact"], rows, given.out
    )
    if given.figure:
        draw(rows, given.figure)


if __name__ == "__main__":
    main()
