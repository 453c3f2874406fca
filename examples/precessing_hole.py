"""A black hole whose axis precesses while its spin grows: horizons and slices, in files of a simulation.

    python examples/precessing_hole.py FOLDER [--moments N] [--layout files|axis|carpet]
    isoembed series FOLDER/h.*.gp --geometry 'FOLDER/slices/slice.{iteration}.h5' -o results
    isoembed series FOLDER/h.*.gp --geometry FOLDER/slices.h5 -o results
    isoembed series FOLDER -o results

The last three are for the three layouts; the last one takes kuibit.

Each slice is one of Kerr in Kerr-Schild coordinates, of mass 1, and the horizon in it is known in closed
form: what comes out can be checked.  The vector a turns about the z-axis at an angle of 0.7, and grows from
0.3 to 0.7.
"""

from pathlib import Path

import numpy as np

from evolution_files import Box, Evolution, written_by_command
from isoembed.relativity import KerrSchild, StarSurface

DURATION = 100.0
STEPS = 8  # iterations in a unit of time
TILT, TURNS = 0.7, 1.5
SPINS = (0.3, 0.7)
SPACING = 0.125


def spin(time):
    """The vector a at a time from 0 to `DURATION`."""
    t = time / DURATION
    phi = 2.0 * np.pi * TURNS * t
    axis = np.array([np.sin(TILT) * np.cos(phi), np.sin(TILT) * np.sin(phi), np.cos(TILT)])
    return (SPINS[0] + (SPINS[1] - SPINS[0]) * t) * axis


def write(folder, moments, layout, spacing=SPACING):
    """Write all moments; return the spins by iteration."""
    evolution, written = Evolution(Path(folder), layout), {}
    for time in np.linspace(0.0, DURATION, moments):
        iteration = round(time * STEPS)
        a = spin(iteration / STEPS)
        geometry = KerrSchild(1.0, a)
        boxes = [[Box((0.0, 0.0, 0.0), 3.0, spacing)]]
        evolution.add(iteration, iteration / STEPS, geometry, boxes)
        surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
        evolution.add_horizon("ah1", iteration, iteration / STEPS, surface)
        written[iteration] = a
    return written


if __name__ == "__main__":
    written_by_command(__doc__, write)
