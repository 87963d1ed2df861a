"""The message names the pressure that turns with the surface and the springs without force, and what to do."""

from scene_motion import output_says


def check(results):
    words = (
        "no rest",
        "stage 'press'",
        "loose_bodies",
        "&boundary pressure turns with the surface",
        "tx, ty",
    )
    output_says(results, *words, never=["max_pseudo_steps follows it"])
