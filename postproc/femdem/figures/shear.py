"""Shear stress against shear displacement of one or several runs, with the empirical law (eq 13) as points.

    femdem-plot shear results_6cm results_12cm --labels "6 cm" "12 cm" --out shear

Prints the error of each run: root mean square and worst difference from eq 13, in per cent of the peak.
"""

import matplotlib.pyplot as plt
import numpy as np

from femdem.figures import style

# Points of the empirical law drawn along a curve; more of them before the peak, where it bends
POINTS_TO_PEAK, POINTS_AFTER = 9, 14
# A row counts as shear once it has moved this part of the largest displacement
MOVED = 1e-6
TABLE = [
    "run",
    "sn_kPa",
    "length_m",
    "peak_eq12_kPa",
    "peak_run_kPa",
    "rms_%_of_peak",
    "worst_%",
    "worst_at_mm",
]


def shear_path(history, group, normal_stress=None):
    """Displacement [mm] and stress [MPa] of the rows that shear, the normal stress [MPa], and which rows these are."""
    u = history.joint(group, "shear_displacement_mm")
    tau = history.joint(group, "shear_stress_MPa")
    sn = history.joint(group, "normal_stress_MPa")
    if len(u) == 0 or np.max(np.abs(u)) == 0:
        raise style.ResultsError(f"{history.path}: group {group!r} has not been sheared")
    moved = np.abs(u) > MOVED * np.max(np.abs(u))
    direction = np.sign(u[moved][-1])
    if normal_stress is None:
        normal_stress = float(np.mean(sn[moved]))
    return direction * u[moved], direction * tau[moved], normal_stress, moved


def points_along(law, normal_stress, last):
    """Displacements at which the empirical law is drawn"""
    up = float(law.peak_displacement(normal_stress))
    before = np.linspace(0, min(up, last), POINTS_TO_PEAK)
    return np.concatenate([before, np.linspace(up, last, POINTS_AFTER)[1:]]) if last > up else before


def draw_shear(axes, runs, labels, group=None, length=None, normal_stress=None, unit="kPa"):
    """Draw the curves with their empirical points; returns the header and rows of the table of errors.

    The normal stress [MPa] of eq 13 is the mean of the history unless given; length [m] that of the block edge.
    """
    scale = 1000.0 if unit == "kPa" else 1.0
    table = []
    for i, (run, label) in enumerate(zip(runs, labels, strict=True)):
        history = run.history
        name = history.group(group)
        u, tau, sn, _ = shear_path(history, name, normal_stress)
        law = run.reference_joint(name, length)
        style.numeric(axes, np.concatenate([[0], u]), scale * np.concatenate([[0], tau]), i, label)
        at = points_along(law, sn, np.max(u))
        style.empirical(axes, at, scale * law.shear_stress(at, sn), i, label)
        peak = float(law.peak_shear_stress(sn))
        error = 100 * (tau - law.shear_stress(u, sn)) / peak
        worst = int(np.argmax(np.abs(error)))
        table.append(
            [
                label,
                1000 * sn,
                law.length,
                1000 * peak,
                1000 * float(np.max(tau)),
                float(np.sqrt(np.mean(error**2))),
                float(error[worst]),
                float(u[worst]),
            ]
        )
    axes.set_xlabel("Shear displacement [mm]")
    axes.set_ylabel(f"Shear stress [{unit}]")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    style.comparison_legend(axes, labels)
    return TABLE, table


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    style.joint_arguments(arguments)
    arguments.add_argument(
        "--normal-stress", type=float, help="normal stress of eq 13 in MPa (default: mean of the history)"
    )
    arguments.add_argument("--unit", choices=["kPa", "MPa"], default="kPa", help="unit of the stress axis")
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    figure, axes = plt.subplots()
    header, table = draw_shear(
        axes, runs, labels, arguments.group, arguments.length, arguments.normal_stress, arguments.unit
    )
    style.error_table(header, table, arguments.csv)
    style.save(figure, arguments.out, runs, "shear")
