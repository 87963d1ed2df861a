"""A free body keeps the speed it has after its masses were raised, whatever opens elsewhere."""

import numpy as np

from femdem.results import Results


def check(results):
    assert len((results / "cracks.csv").read_text().splitlines()) > 1, "nothing broke"
    fields = Results(results).fields
    speed = []
    for step in range(len(fields.times)):
        mesh = fields.mesh(step)
        flying = np.unique(mesh.triangles[mesh.triangle_group == list(mesh.group_name).index("fly")])
        speed.append(fields.read("velocity", step)[flying, 0].mean())
    # Raising the masses at the start has kept the momentum: mass over scaled mass
    assert 0.1 < speed[0] < 0.9, f"the masses are not scaled: {speed[0]} m/s"
    spread = max(speed) - min(speed)
    # Nodes are scaled unequally, so that the body vibrates a little: the mean over its nodes is not quite its speed
    assert spread < 0.03 * speed[0], f"the free body goes from {speed[0]} m/s to {speed[-1]} m/s"
