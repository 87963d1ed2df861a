"""Maps of one network with different joint models side by side, with common colours: shear displacement above,
aperture below, the last snapshot of each run.

femdem-plot models jcm/phase_2b jcm_mean/phase_2b coulomb/phase_2b

Labels are those of the paper (JCM, Model-I, Model-II) from the law of each run with the stage, unless --labels gives others. Prints
the mean, weighted by length, and the largest value of each map.
"""

from femdem.figures import maps, style


def main(words=None):
    arguments = style.parser(__name__, __doc__).parse_args(words)
    runs = [style.Results(directory) for directory in arguments.results]
    panels = [
        maps.Panel(run, -1, f"{maps.model_name(run)}, {maps.stage_name(run.fields.stages[-1])}")
        for run in runs
    ]
    figure = maps.draw_panels(maps.check_labels(arguments.labels, panels))
    style.save(figure, arguments.out, runs, "models")
