"""Aperture at 0.01 MPa, without load, and a micrometre apart, for both couplings and eq 31 to the letter."""

from pathlib import Path

from scene_motion import Motion, changed_deck, run_deck

PAPER = "coupling = 'paper'"
A0 = 0.194  # mm
OPENED = 1e-3  # mm
ROUNDING = 1e-9  # mm, of the columns


def apertures(results):
    """The last three rows, with dilation and closure by stress in them."""
    history = Motion(results).history
    rows = history["joint.aperture_mm"][-3:]
    print(f"aperture {rows} mm at {history['joint.normal_stress_MPa'][-3:]} MPa")
    return rows, history["joint.dilation_mm"][-3:], history["joint.closure_mm"][-3:]


def check(results):
    folder = Path(results).parent
    for name, changed in (("paper", None), ("coupled", "coupling = 'coupled'")):
        run = results
        if changed:
            deck = changed_deck(folder, "aperture.nml", f"{name}.nml", (PAPER, changed))
            run = run_deck(folder, deck, name, "--quiet")
        (pressed, free, apart), dilation, closure = apertures(run)
        assert dilation[1] > A0, "it has dilated by more than its first aperture"
        assert abs(pressed - (A0 + dilation[0] - closure[0])) < ROUNDING, f"{name}: {pressed} mm at 0.01 MPa"
        assert abs(free - (A0 + dilation[1])) < ROUNDING, f"{name}: {free} mm without load"
        assert abs(apart - free - OPENED) < ROUNDING, f"{name}: {apart} mm apart"
        # What is left at 0.01 MPa is the closure under it
        assert 0 < free - pressed < 1e-3, f"{name}: {pressed} mm, {free} mm"
    deck = changed_deck(folder, "aperture.nml", "eq31.nml", (PAPER, PAPER + ", aperture = 'eq31'"))
    (_, free, apart), _, _ = apertures(run_deck(folder, deck, "eq31", "--quiet"))
    assert abs(free - A0) < ROUNDING, f"eq 31: {free} mm"
    assert abs(apart - A0 - OPENED) < ROUNDING, f"eq 31: {apart} mm"
