"""Shear stress of the joint elements of the crack against the law in numpy, at their own normal stress."""

import numpy as np

from femdem.jcm import Joint
from scene_motion import Results

JRC0, JCS0, L0, PHI_R = 10, 100, 0.1, 30
EDGE = 20.0  # mm


def check(results):
    fields = Results(results).fields
    law = Joint(jrc0=JRC0, jcs0=JCS0, l0=L0, phi_r=PHI_R, length=L0)
    found, expected, slip, normal = [], [], [], []
    for step in range(2, len(fields.steps)):  # those of the shearing
        crack = fields.mesh(step).joint_group < 0
        u, tau, sn = (
            fields.read(name, step)[crack]
            for name in ("shear_displacement_mm", "shear_stress_MPa", "normal_stress_MPa")
        )
        assert len(u) == 5, f"{len(u)} joints of cracks: something else has been cut"
        found.append(tau)
        expected.append([law.shear_stress(abs(a), b) for a, b in zip(u, sn, strict=True)])
        slip.append(u)
        normal.append(sn)
    found, expected, slip, normal = (np.array(values) for values in (found, expected, slip, normal))
    peak = law.peak_displacement(normal.mean())
    print(
        f"slip to {slip.max():.2f} mm, {slip.max() / peak:.1f} times that of the peak; normal stress {normal.mean():.2f} MPa"
    )
    assert slip.max() > 3 * peak, "the peak is not well behind"
    # Deeper than the walls of other cracks may overlap: the closure belongs to the law
    closure = -fields.read("opening_mm", 2)[fields.mesh(2).joint_group < 0]
    assert closure.min() > 1e-3 * EDGE, f"closure {closure.min():.4f} mm: the walls are not pressed as meant"
    error = np.sqrt(np.mean((found - expected) ** 2)) / expected.max()
    after = slip > peak
    worst = np.abs(found / expected - 1)[after].max()
    print(f"shear stress: {error:.2e} rms of the peak; after the peak {worst:.2e} at worst")
    assert error < 5e-3, f"shear stress is off by {error:.2e} rms of the peak"
    assert worst < 1e-2, f"shear stress after the peak is off by {worst:.2e}"
