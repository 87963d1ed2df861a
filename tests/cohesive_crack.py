#!/usr/bin/env python3
"""A straight crack that fluid of no viscosity opens, with a cohesive zone at its tips: the reference of cracks driven by fluid.

    python3 tests/cohesive_crack.py        # the table of manual/theory_flow.md

Plane strain, infinite rock, elements of constant displacement discontinuity (Crouch and Starfield 1983, Boundary Element Methods in
Solid Mechanics, ch. 5). In the zone the crack is held together by ft (1 - D/Dc), Dc = 2 G/ft, as in cohesive_m. The fluid has one
pressure, in what is damaged beyond a part of Dc; the tip goes on when the rock ahead of it bears ft.
"""

import math

import numpy as np


class Rock:
    """Plane-strain modulus [Pa], energy of mode I [J/m2], tensile strength [Pa]"""

    def __init__(self, modulus=32e9, energy=30.0, strength=5e6):
        self.modulus, self.energy, self.strength = modulus, energy, strength

    def griffith(self, volume):
        """Half-length [m], opening at the middle [m] and pressure [Pa] of a crack of that volume [m2] without a zone (Geertsma and
        de Klerk 1969; Detournay 2004): K_Ic = p (pi l)^(1/2), w = 4 p l/E', V = pi l w/2"""
        toughness = 4 * math.sqrt(2 / math.pi) * math.sqrt(self.modulus * self.energy)
        stiff = self.modulus * volume
        return (
            2 * math.pi ** (-2 / 3) * (stiff / toughness) ** (2 / 3),
            math.pi ** (-1 / 3) * (toughness**2 * volume / self.modulus**2) ** (1 / 3),
            math.pi ** (1 / 3) / 8 * (toughness**4 / stiff) ** (1 / 3),
        )


def cohesive_crack(rock, half_length, size, enters):
    """Openings of half a crack from its middle to its tip [m], pressure [Pa] and length that is wet [m].

    size: length of the elements; enters: damage (opening over Dc) from which on fluid is in.
    """
    count = round(half_length / size)
    x = (np.arange(count) + 0.5) * size

    def closing(at, place):
        """Stress that closes, of one metre of opening"""
        return rock.modulus / (4 * math.pi) * (1 / (at - place + size / 2) - 1 / (at - place - size / 2))

    stiffness = closing(x[:, None], x) + closing(x[:, None], -x)
    ahead = closing(x[-1] + size, x) + closing(x[-1] + size, -x)
    open_at = 2 * rock.energy / rock.strength
    softens = x > half_length - rock.modulus * rock.energy / rock.strength**2
    wet = np.ones(count, bool)
    for _ in range(200):
        matrix = np.zeros((count + 1, count + 1))
        matrix[:count, :count] = stiffness - np.diag(softens * rock.strength / open_at)
        matrix[:count, count] = -1.0 * wet
        matrix[count, :count] = -ahead
        found = np.linalg.solve(matrix, np.append(-rock.strength * softens, rock.strength))
        opening, pressure = found[:-1], found[-1]
        if np.array_equal(opening < open_at, softens) and np.array_equal(opening > enters * open_at, wet):
            return opening, pressure, size * wet.sum()
        softens, wet = opening < open_at, opening > enters * open_at
    raise RuntimeError("no zone agrees with its openings")


def main():
    rock, size = Rock(), 0.0025
    for enters in (0.1, 0.72):
        for half_length in (0.1, 0.2, 0.4, 0.8):
            opening, pressure, wet = cohesive_crack(rock, half_length, size, enters)
            reference = rock.griffith(2 * size * opening.sum())
            over = [
                f"{100 * (a / b - 1):+.1f} %"
                for a, b in zip((wet, opening[0], pressure), reference, strict=True)
            ]
            print(f"fluid enters at {enters}, to {half_length} m: l, w, p {', '.join(over)}")


if __name__ == "__main__":
    main()
