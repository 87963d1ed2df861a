#!/usr/bin/env python3
"""A straight crack that a viscous fluid opens from its middle: the reference of cracks driven by fluid that may lag behind.

    python3 tests/viscous_crack.py [--size 0.05] [--confined 20e6]

Plane strain, infinite rock under a confining stress, elements of constant displacement discontinuity (Crouch and Starfield 1983,
Boundary Element Methods in Solid Mechanics, ch. 5), half of the crack. In the zone the rock is held together by ft (1 - w/wc),
wc = 2 G/ft, as in cohesive_m. Fluid flows by the cubic law from element to element; each node has what the elements beside it
hold, half each. A node that is full has a pressure, one that is not has none (fluid_front_m): implicit Euler and Newton's method
with the whole influence of the elements on each other, steps halved where that finds nothing.

The similarity solution is that without toughness and without lag (the M-vertex: Adachi and Detournay 2002, Int J Numer Anal Meth
Geomech 26:579; Garagash and Detournay 2005, J Appl Mech 72:868).
"""

import argparse
import math
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Case:
    """Rock, fluid and injection into both wings, and how the crack is cut into elements"""

    modulus: float = 32e9  # plane strain [Pa]
    energy: float = 30.0  # of mode I [J/m2]
    strength: float = 2e6  # [Pa]
    confined: float = 20e6  # [Pa]
    viscosity: float = 0.1  # [Pa s]
    rate: float = 1e-4  # [m2/s]
    size: float = 0.05  # of the elements [m]
    notch: float = 0.1  # half-length of the notch [m]
    notch_open: float = 2e-4  # what it is open by, not counting what the rock gives way by [m]
    enters: float = 0.1  # damage from which on fluid may be in the crack

    def similarity(self, time):
        """Half-length [m], opening at the middle [m] and pressure beyond the confining stress there [Pa]"""
        slow = 12 * self.viscosity
        length = 0.6152 * (self.modulus * self.rate**3 / slow) ** (1 / 6) * time ** (2 / 3)
        opening = math.sqrt(2.1 * math.sqrt(slow * self.rate / self.modulus) * length)
        return length, opening, 0.62 * math.sqrt(slow * self.rate * self.modulus) / opening

    def toughness(self):
        """Dimensionless: K'/(E'^3 mu' Q)^(1/4); viscosity governs below 1"""
        toughness = 4 * math.sqrt(2 / math.pi) * math.sqrt(self.modulus * self.energy)
        return toughness / (self.modulus**3 * 12 * self.viscosity * self.rate) ** 0.25


class NoStepError(Exception):
    """Newton's method, or the search for the zone, has found nothing"""


@dataclass
class Crack:
    """Half of the crack at a time"""

    case: Case
    count: int
    time: float = 0.0
    opening: np.ndarray = field(init=False)  # of the elements, without notch_open [m]
    most: np.ndarray = field(init=False)  # largest so far where the rock holds together [m]
    conducts: np.ndarray = field(init=False)
    pressure: np.ndarray = field(init=False)  # at the nodes [Pa]
    content: np.ndarray = field(init=False)  # of the nodes [m2]

    def __post_init__(self):
        case, number = self.case, np.arange(self.count)
        x = (number + 0.5) * case.size
        self.rock = number >= round(case.notch / case.size)
        self.stiffness = self.closing(x[:, None] - x) + self.closing(x[:, None] + x)
        self.mean = np.zeros((self.count, self.count + 1))
        self.mean[number, number] = self.mean[number, number + 1] = 0.5
        self.opening, self.most = np.zeros((2, self.count))
        self.conducts = ~self.rock
        self.pressure = np.append(np.where(self.conducts, case.confined, 0.0), 0.0)
        self.opening, _ = self.rest(self.pressure, self.opening)
        self.content = self.capacity(self.opening)
        self.injected = np.zeros(self.count + 1)
        self.injected[0] = case.rate / 2

    def closing(self, distance):
        """Stress that closes, of one metre of opening"""
        half = self.case.size / 2
        return self.case.modulus / (4 * math.pi) * (1 / (distance + half) - 1 / (distance - half))

    def rest(self, pressure, opening):
        """Openings under pressures at the nodes, and what they gain for a pascal more at each element"""
        case, open_at = self.case, 2 * self.case.energy / self.case.strength
        push = self.mean @ pressure - case.confined
        holds = self.rock & (self.most < open_at)
        is_open = (opening > 0) | ~self.rock
        softens = is_open & holds & (opening < open_at)
        loads = softens & (opening >= self.most)
        for _ in range(1000):
            before = np.maximum(self.most, 1e-30)
            back = case.strength * (1 - before / open_at) / before
            spring = np.where(loads, -case.strength / open_at, np.where(softens & ~loads, back, 0.0))
            part = np.flatnonzero(is_open)
            matrix = self.stiffness[np.ix_(part, part)] + np.diag(spring[part])
            found = np.zeros(self.count)
            found[part] = np.linalg.solve(matrix, (push - np.where(loads, case.strength, 0.0))[part])
            pull = push - self.stiffness @ found
            strength = np.where(self.rock & (self.most <= 0), case.strength, 0.0)
            now = is_open.copy()
            shut, opens = is_open & (found < 0), ~is_open & (pull > strength + 1e-6 * case.strength)
            if shut.any():
                now[np.flatnonzero(shut)[-1]] = False
            elif opens.any():
                now[np.flatnonzero(opens)[0]] = True
            soft_now = now & holds & (found < open_at)
            loads_now = soft_now & (found >= self.most)
            if all(map(np.array_equal, (now, soft_now, loads_now), (is_open, softens, loads))):
                part = np.flatnonzero(is_open | self.conducts)
                answer = np.zeros((self.count, self.count))
                matrix = self.stiffness[np.ix_(part, part)] + np.diag(spring[part])
                answer[np.ix_(part, part)] = np.linalg.inv(matrix)
                return found, answer
            is_open, softens, loads = now, soft_now, loads_now
        raise NoStepError

    def aperture(self, opening):
        """Of the elements that conduct [m]"""
        return np.where(self.conducts, opening + np.where(self.rock, 0.0, self.case.notch_open), 0.0)

    def capacity(self, opening):
        """Of the nodes [m2]"""
        return self.case.size * self.mean.T @ self.aperture(opening)

    def balance(self, pressure, opening, step):
        """What is over at the nodes, what flows in, conductances of the elements"""
        conductance = self.aperture(opening) ** 3 / (12 * self.case.viscosity * self.case.size)
        along = -conductance * np.diff(pressure)
        net = self.injected - np.append(along, 0.0) + np.append(0.0, along)
        return self.content + step * net - self.capacity(opening), net, conductance

    def advance(self, step):
        """One step, or NoStepError with all as it was"""
        entered = self.conducts
        pressure, opening = self.pressure, self.opening
        try:
            while True:
                pressure, opening, net = self.newton(pressure, opening, step)
                damaged = self.rock & (
                    np.maximum(self.most, opening)
                    > self.case.enters * 2 * self.case.energy / self.case.strength
                )
                if not (damaged & ~self.conducts).any():
                    break
                self.conducts = self.conducts | damaged
        except (NoStepError, np.linalg.LinAlgError):
            self.conducts = entered
            raise NoStepError from None
        self.content = np.maximum(0.0, self.content + step * net)
        self.pressure, self.opening = pressure, opening
        self.most = np.maximum(self.most, np.where(self.rock, opening, 0.0))
        self.time += step

    def newton(self, pressure, opening, step):
        """Pressures and openings at the end of a step, and what flows in"""
        scale = 0.5 * self.case.rate * step
        opening, answer = self.rest(pressure, opening)
        over, net, conductance = self.balance(pressure, opening, step)
        there = self.capacity(opening) > 0
        there[np.flatnonzero(self.conducts)[-1] + 1] = True
        for _ in range(12):
            missed = there * np.where(pressure > 0, over, np.maximum(over, 0.0))
            if abs(missed).max() <= 1e-6 * scale:
                return pressure, opening, net
            wet = np.flatnonzero(there & ((pressure > 0) | (over > 0)))
            gain = answer @ self.mean
            aperture = np.maximum(self.aperture(opening), 1e-30)
            along = (-3 * conductance / aperture * np.diff(pressure))[:, None] * gain
            number = np.arange(self.count)
            along[number, number] += conductance
            along[number, number + 1] -= conductance
            none = np.zeros((1, self.count + 1))
            matrix = step * (np.vstack([along, none]) - np.vstack([none, along]))
            matrix += self.case.size * self.mean.T @ (self.conducts[:, None] * gain)
            change = np.zeros(self.count + 1)
            change[wet] = np.linalg.solve(matrix[np.ix_(wet, wet)], over[wet])
            closes = (gain @ change / aperture)[self.conducts].min()
            part = min(1.0, 0.8 / -closes) if closes < 0 else 1.0
            for _ in range(4):
                tried = np.maximum(pressure + part * change, 0.0)
                opened, answer = self.rest(tried, opening)
                over, net, conductance = self.balance(tried, opened, step)
                now = there * np.where(tried > 0, over, np.maximum(over, 0.0))
                if np.linalg.norm(now) < (1 - 1e-4 * part) * np.linalg.norm(missed):
                    break
                part *= 0.5
            else:
                raise NoStepError
            pressure, opening = tried, opened
        raise NoStepError


def viscous_crack(case, times, longest_step=0.08):
    """The crack at each of the times: half-length that conducts [m], opening at the middle [m], pressure there beyond the confining
    stress [Pa]"""
    crack = Crack(case, round(1.5 * case.similarity(max(times))[0] / case.size))
    step = longest_step
    for time in times:
        while crack.time < time * (1 - 1e-12):
            now = (time - crack.time) / math.ceil((time - crack.time) / step - 1e-9)
            try:
                crack.advance(now)
                step = min(longest_step, 1.4 * max(step, now))
            except NoStepError:
                step = 0.5 * now
                if step < 1e-6 * longest_step:
                    raise RuntimeError("no step is short enough") from None
        yield case.size * crack.conducts.sum(), crack.opening[0], crack.pressure[0] - case.confined


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=float, default=0.05)
    parser.add_argument("--confined", type=float, default=20e6)
    arguments = parser.parse_args()
    case, times = Case(size=arguments.size, confined=arguments.confined), (2.5, 5.0, 10.0)
    print(f"toughness {case.toughness():.2f}")
    for time, found in zip(times, viscous_crack(case, times), strict=True):
        over = [f"{100 * (a / b - 1):+.1f} %" for a, b in zip(found, case.similarity(time), strict=True)]
        print(
            f"{time} s: l {found[0]:.3f} m, w {1e3 * found[1]:.4f} mm, p {1e-6 * found[2]:.3f} MPa: {', '.join(over)}"
        )


if __name__ == "__main__":
    main()
