"""A crack along a given line that fluid opens from a well: half of it, with the well on the side of the model."""

import numpy as np

from flow_grid import Grid

RUN = "&run mesh = 'mesh.msh', solver = 'implicit' /\n"
YOUNG, POISSON = 30e9, 0.25
RATE = 1e-5
# Length of an element along the line [m], and elements of notch and line
WIDTH, LONGEST = 0.04, 15
# What the notch is open by before anything flows [m]
NOTCH_OPEN = 1e-5
COHESIVE = (
    "&cohesive group = 'rock', curve = '{}', insertion = {}, tensile_strength = 5e6, cohesion = 20e6,"
    " friction_angle = 30, g_i = 30, g_ii = 300 /\n"
)


def half_a_crack(folder, width=WIDTH, notch=2, longest=LONGEST, extent=4.0, growth=1.5):
    """Rock on one side of a well, with a notch at it and the line that the crack is to take; place of the well.

    width: length of the elements; notch, longest: elements of the notch, and of notch and line; beyond them elements grow by a
    factor up to an extent.
    """
    columns = [width * i for i in range(longest + 1)]
    rows = [width * i for i in range(4)]
    for lines in (columns, rows):
        step = width
        while lines[-1] < extent:
            step *= growth
            lines.append(lines[-1] + step)
    rows = np.array([-y for y in rows[:0:-1]] + rows) + rows[-1]
    middle = rows[len(rows) // 2]
    grid = Grid(1.0, 1.0, len(columns) - 1, len(rows) - 1)
    grid.place(columns, rows)
    grid.fracture("notch", (0, middle), (columns[notch], middle))
    grid.fracture("path", (columns[notch], middle), (columns[longest], middle))
    grid.point("well", (0, middle))
    grid.write(folder / "mesh.msh")
    return np.array([0, middle])


def injection(times, steps, curve="path", insertion="'regions'"):
    """Deck: rock of mode-I toughness sqrt(G E/(1 - nu^2)), fluid without viscosity to speak of, half the rate in half the crack."""
    deck = RUN + f"&material group = 'rock', density = 2500, young = {YOUNG}, poisson = {POISSON} /\n"
    deck += (
        "&joint group = 'notch', law = 'coulomb', friction_angle = 30, normal = 'penalty', a0_mm = 0.01 /\n"
    )
    deck += "&boundary group = 'left', vx = 0 /\n&boundary group = 'corner_sw', vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    deck += COHESIVE.format(curve, insertion) + "&fluid viscosity = 1e-6, compressibility = 0 /\n"
    deck += "&flow coupling = 'two-way', permeability = .false., max_passes = 60 /\n"
    deck += f"&transient step = {times[0] / steps}, steps = 'fixed' /\n&flow_boundary group = 'well', rate = {RATE / 2} /\n"
    before = 0.0
    for number, time in enumerate(times):
        deck += f"&stage name = 't{number}', move_time = {time - before}, equilibrium = 1e-6 /\n"
        before = time
    return deck
