"""The largest load gives the fracture toughness sqrt(G_I E/(1 - nu^2))."""

import math

import numpy as np
from scene import read_history

WIDTH, HALF_CRACK, SPEED = 3.2, 0.4, 0.006
TOUGHNESS = math.sqrt(100 * 30e9 / (1 - 0.27**2))


def check(results):
    history = read_history(results / "history.csv")
    time = np.concatenate([[0.0], history["time_s"]])
    work = np.concatenate([[0.0], history["external_J"]])
    stress = np.diff(work) / (np.diff(time) * SPEED * WIDTH)
    # Feddersen's finite-width correction; the plate is twice as high as wide
    found = stress.max() * math.sqrt(math.pi * HALF_CRACK / math.cos(math.pi * HALF_CRACK / WIDTH))
    error = found / TOUGHNESS - 1
    print(f"toughness: expected {TOUGHNESS / 1e6:.4f}, found {found / 1e6:.4f} MPa m^0.5 ({error:+.2%})")
    assert abs(error) < 0.05, f"toughness {found / 1e6:.4f}, expected {TOUGHNESS / 1e6:.4f} MPa m^0.5"
    assert stress.argmax() < stress.size - 1, "the load is still growing at the end"
