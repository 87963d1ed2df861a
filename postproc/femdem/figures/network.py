"""Maps of shear displacement (above) and aperture (below) of a network, phase by phase, with common colours.

femdem-plot network phase_1 phase_2a phase_2b          one map a results directory: its last snapshot
femdem-plot network phase_2b                           one map a stage of the run

Cracks, when there are any, are drawn in red. Prints the mean, weighted by length, and the largest value of each map.
"""

from femdem.figures import maps, style


def stage_ends(run):
    """The last snapshot of every stage of a run"""
    stages = run.fields.stages
    last = [k for k in range(len(stages)) if k + 1 == len(stages) or stages[k + 1] != stages[k]]
    return [maps.Panel(run, k, maps.stage_name(stages[k])) for k in last]


def main(words=None):
    arguments = style.parser(__name__, __doc__).parse_args(words)
    runs = [style.Results(directory) for directory in arguments.results]
    panels = stage_ends(runs[0]) if len(runs) == 1 else [stage_ends(run)[-1] for run in runs]
    figure = maps.draw_panels(maps.check_labels(arguments.labels, panels))
    style.save(figure, arguments.out, runs, "network")
