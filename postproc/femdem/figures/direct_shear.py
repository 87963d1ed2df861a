"""Direct shear tests at a glance: shear stress and dilation, with the empirical law as points.

    femdem-plot direct_shear results_6cm results_12cm --labels "6 cm" "12 cm" --out direct_shear

Prints the errors of each run against eqs 13 and 18.
"""

import matplotlib.pyplot as plt

from femdem.figures import style
from femdem.figures.dilation import draw_dilation
from femdem.figures.shear import draw_shear


def main(words=None):
    arguments = style.parser(__name__, __doc__)
    style.joint_arguments(arguments)
    arguments.add_argument(
        "--normal-stress", type=float, help="normal stress of the laws in MPa (default: mean of the history)"
    )
    arguments = arguments.parse_args(words)
    runs, labels = style.open_results(arguments)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(2 * style.WIDTH_MM * style.MM, style.HEIGHT_MM * style.MM)
    )
    options = (arguments.group, arguments.length, arguments.normal_stress)
    print("Shear stress against eq 13")
    style.error_table(*draw_shear(left, runs, labels, *options), arguments.csv)
    print("Dilation against the integral of eq 18")
    style.error_table(*draw_dilation(right, runs, labels, *options), None)
    if len(runs) == 1:
        figure.suptitle(labels[0])
    style.save(figure, arguments.out, runs, "direct_shear")
