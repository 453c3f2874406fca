"""A sheet that swells.

A disc whose center swells more than its edge: three states of a film, each the surface of least bending with
the lengths of its metric.
"""

import isoembed
from isoembed.plot import Panel, frames_of, panels, write_animation
from isoembed.smooth import ChartMetric, triangulate_metric


def swollen(strength):
    """Lengths at a distance r from the center are multiplied by 1 - strength r^2."""

    def components(x, y):
        factor = (1 - strength * (x * x + y * y)) ** 2
        return factor, 0 * x, factor

    return ChartMetric(components)


mesh, strengths = triangulate_metric(swollen(0.3), 120, zone=(0.0, 1.0)), (0.05, 0.15, 0.3)
states = [isoembed.embed(mesh.measured(swollen(each)), boundary="free") for each in strengths]
frames = frames_of(states, [f"strength {strength}" for strength in strengths])
write_animation("swelling.gif", states[-1], frames)
assert states[0].surface.bending_energy < states[1].surface.bending_energy < states[2].surface.bending_energy
row = [Panel(f.vertices, mesh.faces, s.mean_curvature, f.stage) for f, s in zip(frames, states, strict=True)]
panels(row, label="mean curvature", bounds=(0.0, 2.0)).savefig("swelling.png", dpi=150)
