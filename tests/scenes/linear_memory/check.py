"""The message names the linear solver, its memory, the place in the run and what helps; no word of slip or collapse."""

from scene_motion import output_says


def check(results):
    words = (
        "linear solver has not enough memory",
        "unknowns",
        "MB",
        "stage 'press'",
        "cycle 1",
        "max_memory",
    )
    output_says(results, *words, never=("nothing holds", "pseudo-time", "INFOG"))
