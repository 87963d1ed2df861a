#!/usr/bin/env python3
"""Mesh of fractured rock around a round tunnel that is still full of rock.

    bin/python3 make_mesh.py --out tunnel.msh

Two sets of fractures are drawn from a seed in a square around the tunnel (femdem-traces); the tunnel is the physical surface
'tunnel', the rest 'rock' (femdem-mesh --zone). Fractures go through both. Lengths are in metres, angles in degrees.
"""

import argparse
import csv
import math
from pathlib import Path

from femdem.network import make_mesh, make_traces


def main():
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--out", type=Path, default=Path("tunnel.msh"))
    arguments.add_argument("--seed", type=int, default=5, help="of the fractures")
    arguments.add_argument("--radius", type=float, default=2.5, help="of the tunnel")
    arguments.add_argument("--side", type=float, default=30.0, help="of the square")
    arguments.add_argument("--p21", type=float, default=0.45, help="length of fractures per area (1/m)")
    arguments.add_argument("--size", type=float, default=0.35, help="of the elements at fractures and tunnel")
    arguments.add_argument("--sides", type=int, default=48, help="of the polygon that the tunnel is")
    chosen = arguments.parse_args()

    traces, outline = chosen.out.with_name("traces.csv"), chosen.out.with_name("outline.csv")
    of_side = ["--seed", str(chosen.seed), "--side", str(chosen.side), "--p21", str(chosen.p21)]
    sets = ["--strikes", "30", "110", "--shortest", "4", "--longest", "20"]
    make_traces.main([*of_side, *sets, "--out", str(traces)])
    middle = 0.5 * chosen.side
    with outline.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["x", "y"])
        for k in range(chosen.sides):
            angle = 2 * math.pi * (k + 0.5) / chosen.sides
            place = middle + chosen.radius * math.cos(angle), middle + chosen.radius * math.sin(angle)
            writer.writerow([f"{value:.6f}" for value in place])
    return make_mesh.main(
        [str(traces), "--size", str(chosen.size), "--out", str(chosen.out), "--zone", str(outline), "tunnel"]
    )


if __name__ == "__main__":
    raise SystemExit(main())
