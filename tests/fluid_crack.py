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


def half_a_crack(folder, width=WIDTH, notch=2, longest=LONGEST, extent=4.0, growth=1.5, angle=0.0):
    """Rock on one side of a well, with a notch at it and the line that the crack is to take; place of the well.

    width: length of the elements; notch, longest: elements of the notch, and of notch and line; beyond them elements grow by a
    factor up to an extent. angle: all turned by it about the origin [degrees].
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
    grid.write(folder / "mesh.msh", angle)
    return middle * np.array([-np.sin(np.radians(angle)), np.cos(np.radians(angle))])


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


def viscous_injection(case, times, longest_step=0.08, parts=1):
    """Deck: confined rock, a notch that is open a little, fluid that its viscosity holds back and that may lag behind the tip.

    case: viscous_crack.Case; times: ends of the stages [s], counted from the start of two of 1 ms; parts: outputs of each.
    """
    deck = RUN + f"&material group = 'rock', density = 2500, young = {YOUNG}, poisson = {POISSON} /\n"
    assert np.isclose(case.modulus, YOUNG / (1 - POISSON**2))
    deck += "&joint group = 'notch', law = 'coulomb', friction_angle = 30, normal = 'penalty', "
    deck += f"a0_mm = {1e3 * case.notch_open} /\n"
    deck += "&boundary group = 'left', vx = 0 /\n&boundary group = 'corner_sw', vy = 0 /\n&boundary group = 'corner_se', vy = 0 /\n"
    for side, push in (("top", "ty = -{}"), ("bottom", "ty = {}"), ("right", "tx = -{}")):
        deck += f"&boundary group = '{side}', stage = 'confine', {push.format(case.confined)} /\n"
    deck += COHESIVE.format("path", "'regions'").replace("5e6", f"{case.strength}")
    deck = deck.replace("g_i = 30,", f"g_i = {case.energy},")
    deck += f"&fluid viscosity = {case.viscosity}, compressibility = 0 /\n"
    deck += "&flow coupling = 'two-way', permeability = .false., tolerance = 1e-3, fluid_lag = .true., "
    deck += f"fluid_enters = {case.enters} /\n&transient step = {longest_step} /\n"
    # A rate grows over the cycles of its stage
    deck += f"&flow_boundary group = 'well', stage = 'start', rate = {case.rate / 2} /\n"
    deck += "&stage name = 'confine', move_time = 1e-3 /\n&stage name = 'start', move_time = 1e-3 /\n"
    before = 0.0
    for number, time in enumerate(times):
        deck += f"&stage name = 't{number}', cycles = {parts}, move_time = {(time - before) / parts} /\n"
        before = time
    return deck


def viscous_mesh(folder, case, longest, extent=16.0, angle=0.0):
    """Half a crack of notch and line, cut like the case; place of the well"""
    notch, line = round(case.notch / case.size), round(longest / case.size)
    return half_a_crack(folder, case.size, notch, line, extent, 1.4, angle)


def crack_found(case, well, x, fields):
    """Half-length that conducts [m], opening at the middle [m], pressure there beyond the confining stress [Pa]"""
    conducts = fields["hydraulic_aperture_mm"] > 0
    place = np.flatnonzero(np.isclose(x, well).all(axis=1))[0]
    opening = 1e-3 * fields["aperture_mm"].max() - case.notch_open
    return case.size * conducts.sum(), opening, fields["fluid_pressure"][place] - case.confined
