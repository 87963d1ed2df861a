"""The empirical joint law (equations 5 to 22 of the theory page) in numpy, written apart from the solver.

Reference curves of the figures come from here, so that a figure compares two independent programs. Where the law ends, the
guards of the theory page hold here too, and `guards` names those that act. Stresses are in MPa,
displacements in mm, angles in degrees and lengths in m, as in the equations.

    joint = Joint(jrc0=15, jcs0=2, l0=0.06, phi_r=32, length=0.12)
    joint.shear_stress(u, normal_stress=0.0245)
"""

from dataclasses import dataclass

import numpy as np

# Table 1: u/up and JRCmob/JRCn from 0.3 on; below 0.3 the mobilised angle grows from zero in a straight line.
TABLE_RATIO = np.array([0.3, 0.6, 1.0, 2.0, 4.0, 10.0, 25.0, 100.0])
TABLE_JRC = np.array([0.0, 0.75, 1.0, 0.85, 0.70, 0.50, 0.40, 0.0])
ROUGHNESS_STARTS = 0.3
METRES = 1e-3  # in a millimetre
# Intervals in which eq 18 is integrated: the error of the trapezoidal rule is then below 1e-7 mm
INTERVALS_TO_PEAK = 4000
INTERVALS_AFTER_PEAK = 40000
# Guards (section 7 of the theory page): closure, as a share of vm, beyond which eq 5 goes on along its tangent; floors of
# vm as a share of a0, of kn0 [MPa/mm] and of a0 [mm]; largest log10(JCSn/sn), and its floor in eq 21; largest angle a tangent
# is taken of
CLOSURE_LIMIT = 0.99
# Constants of the largest closure by loading cycle (Bandis et al. 1983); the third is eq 7
CYCLES = {
    1: (-0.2960, -0.0056, 2.2410, -0.2450),
    2: (-0.1005, -0.0073, 1.0082, -0.2301),
    3: (-0.1032, -0.0074, 1.1350, -0.2510),
}
LEAST_CLOSURE_SHARE, LEAST_STIFFNESS, LEAST_APERTURE = 0.05, 0.1, 0.01
WIDEST_LOGARITHM, LEAST_LOGARITHM = 6.0, 1e-3
STEEPEST = 89.0


@dataclass
class Joint:
    """One joint of effective length `length`."""

    jrc0: float
    jcs0: float  # MPa
    l0: float  # m
    phi_r: float  # degrees
    length: float  # m
    a0: float | None = None  # mm; eq 10 when None
    sigma_c: float | None = None  # MPa; jcs0 when None
    peak: str = "eq15"
    post_peak: str = "table"
    short_edges: str = "extrapolate"
    max_angle: float = 70.0  # degrees
    closure_cycle: int = 3

    def __post_init__(self):
        if self.peak not in ("eq14", "eq15"):
            raise ValueError(f"peak = {self.peak!r}: expected 'eq14' or 'eq15'")
        if self.post_peak not in ("table", "eq16"):
            raise ValueError(f"post_peak = {self.post_peak!r}: expected 'table' or 'eq16'")
        if self.closure_cycle not in CYCLES:
            raise ValueError(f"closure_cycle = {self.closure_cycle!r}: expected 1, 2 or 3")
        if self.sigma_c is None:
            self.sigma_c = self.jcs0
        if self.a0 is None:
            self.a0 = self.jrc0 / 5 * (0.2 * self.sigma_c / self.jcs0 - 0.1)  # eq 10
        self.a0 = max(self.a0, LEAST_APERTURE)

    @property
    def effective_length(self):
        """Length that scales roughness and strength [m]."""
        return max(self.length, self.l0) if self.short_edges == "l0" else self.length

    @property
    def jrcn(self):
        return self.jrc0 * (self.effective_length / self.l0) ** (-0.02 * self.jrc0)  # eq 8

    @property
    def jcsn(self):
        return self.jcs0 * (self.effective_length / self.l0) ** (-0.03 * self.jrc0)  # eq 9

    # ---- Normal -----------------------------------------------------------------------------------------------

    @property
    def initial_stiffness(self):
        """kn0 [MPa/mm]"""
        return max(self._fitted_stiffness, LEAST_STIFFNESS)

    @property
    def largest_closure(self):
        """vm [mm]"""
        return max(self._fitted_closure, LEAST_CLOSURE_SHARE * self.a0)

    @property
    def _fitted_stiffness(self):
        return -7.15 + 1.75 * self.jrcn + 0.02 * self.jcsn / self.a0  # eq 6

    @property
    def _fitted_closure(self):
        a, b, c, d = CYCLES[self.closure_cycle]
        return a + b * self.jrcn + c * (self.jcsn / self.a0) ** d  # eq 7

    @property
    def _limit(self):
        """Stress [MPa] at the closure limit, and stiffness [MPa/mm] beyond it"""
        kn0, vm = self.initial_stiffness, self.largest_closure
        return kn0 * vm * CLOSURE_LIMIT / (1 - CLOSURE_LIMIT), kn0 / (1 - CLOSURE_LIMIT) ** 2

    def closure(self, normal_stress):
        """Closure [mm] under a normal stress [MPa]"""
        sn = np.asarray(normal_stress, dtype=float)
        kn0, vm = self.initial_stiffness, self.largest_closure
        limit, beyond = self._limit
        bounded = np.minimum(sn, limit)
        return bounded * vm / (kn0 * vm + bounded) + (sn - bounded) / beyond  # eq 5b

    def normal_stress(self, closure):
        """Normal stress [MPa] of a closure [mm]"""
        v = np.asarray(closure, dtype=float)
        vm = self.largest_closure
        bounded = np.minimum(v, CLOSURE_LIMIT * vm)
        return self.initial_stiffness * bounded / (1 - bounded / vm) + (v - bounded) * self._limit[1]  # eq 5a

    # ---- Shear ------------------------------------------------------------------------------------------------

    @property
    def _largest_logarithm(self):
        """log10(JCSn/sn) at which the total angle reaches its cap"""
        room = max(0.0, min(self.max_angle, STEEPEST) - self.phi_r)
        return room / self.jrcn if self.jrcn * WIDEST_LOGARITHM > room else WIDEST_LOGARITHM

    def _logarithm(self, normal_stress):
        """log10(JCSn/sn): zero where the stress exceeds the strength of the walls, held where the angle is capped"""
        log = np.log10(self.jcsn / np.asarray(normal_stress, dtype=float))
        return np.clip(log, 0.0, self._largest_logarithm)

    def _roughness_angle(self, normal_stress):
        """JRCn log10(JCSn/sn) [degrees]"""
        return self.jrcn * self._logarithm(normal_stress)

    def guards(self, normal_stress):
        """Names of the guards that act under a normal stress [MPa]: outside the validity of the law if any."""
        log = np.log10(self.jcsn / normal_stress)
        acting = {
            "angle capped": log > self._largest_logarithm,
            "sn >= JCSn": log < LEAST_LOGARITHM,  # as good as: there is no roughness angle left
            "vm floored": self._fitted_closure < LEAST_CLOSURE_SHARE * self.a0,
            "kn0 floored": self._fitted_stiffness < LEAST_STIFFNESS,
            "closure > 0.99 vm": normal_stress > self._limit[0],
        }
        return [name for name, acts in acting.items() if acts]

    def peak_displacement(self, normal_stress):
        """up [mm]"""
        length = self.effective_length
        if self.peak == "eq14":
            up = length / 500 * (self.jrcn / length) ** 0.33  # eq 14
            return up / METRES + 0.0 * np.asarray(normal_stress, dtype=float)
        log = self._logarithm(normal_stress)
        angle = np.radians(self.jrcn * log)
        return 0.0077 * length**0.45 * 10.0 ** (-0.34 * log) * np.cos(angle) / METRES  # eq 15

    def mobilised_ratio(self, ratio):
        """JRCmob/JRCn against u/up from the start of the roughness on (0 before)"""
        ratio = np.abs(np.asarray(ratio, dtype=float))
        mobilised = np.interp(ratio, TABLE_RATIO, TABLE_JRC)  # Table 1
        if self.post_peak == "eq16":
            mobilised = np.where(ratio > 1, np.maximum(ratio, 1.0) ** -0.381, mobilised)  # eq 16
        return mobilised

    def mobilised_angle(self, u, normal_stress):
        """Mobilised friction angle [degrees]: JRCmob log10(JCSn/sn) + phi_r"""
        ratio = np.abs(np.asarray(u, dtype=float)) / self.peak_displacement(normal_stress)
        rough = self.mobilised_ratio(ratio) * self._roughness_angle(normal_stress) + self.phi_r
        return np.where(ratio < ROUGHNESS_STARTS, self.phi_r * ratio / ROUGHNESS_STARTS, rough)

    def shear_stress(self, u, normal_stress):
        """Shear stress [MPa] at a shear displacement [mm]"""
        return normal_stress * np.tan(np.radians(self.mobilised_angle(u, normal_stress)))  # eq 13

    def peak_shear_stress(self, normal_stress):
        """taup [MPa]"""
        return normal_stress * np.tan(np.radians(self._roughness_angle(normal_stress) + self.phi_r))  # eq 12

    # ---- Dilation ---------------------------------------------------------------------------------------------

    def damage_coefficient(self, normal_stress):
        """M [-]"""
        log = np.maximum(self._logarithm(normal_stress), LEAST_LOGARITHM)
        return self.jrcn / (12 * log) + 0.70  # eq 21

    def dilation_slope(self, ratio, normal_stress):
        """tan of the mobilised dilation angle at u/up"""
        m = self.damage_coefficient(normal_stress)
        rough = self._roughness_angle(normal_stress)
        before = np.tan(np.radians(rough / (3 * m))) * (4 * ratio - 1)  # eqs 19, 20
        after = np.tan(np.radians(self.mobilised_ratio(ratio) * rough / m))  # eq 22
        return np.where(ratio <= 1, before, after)

    def dilation(self, u, normal_stress):
        """Dilation [mm] at a shear displacement [mm] under a constant normal stress: eq 18 integrated"""
        u = np.abs(np.asarray(u, dtype=float))
        up = float(self.peak_displacement(normal_stress))
        # The slope jumps at the peak, so each side is integrated on its own.
        before = np.linspace(0.0, 1.0, INTERVALS_TO_PEAK + 1)
        rise = _integral(before, self.dilation_slope(before, normal_stress))
        last = max(1.0, float(np.max(u, initial=0.0)) / up)
        after = np.linspace(1.0, last, INTERVALS_AFTER_PEAK + 1)
        slope = self.dilation_slope(np.maximum(after, np.nextafter(1.0, 2.0)), normal_stress)
        further = rise[-1] + _integral(after, slope)
        ratio = np.concatenate([before, after[1:]])
        return up * np.interp(u / up, ratio, np.concatenate([rise, further[1:]]))


def _integral(x, slope):
    """Running integral by the trapezoidal rule"""
    return np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(x))])
