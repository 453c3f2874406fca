"""Two black holes that approach each other: horizons and slices, in files as simulations write them.

    python examples/approaching_pair.py FOLDER [--moments N] [--layout files|axis|carpet]
    isoembed series FOLDER/h.*.gp --geometry 'FOLDER/slices/slice.{iteration}.h5' -o results
    isoembed series FOLDER/h.*.gp --geometry FOLDER/slices.h5 -o results
    isoembed series FOLDER -o results

The last three are for the three layouts; the last one takes kuibit.

Each slice is that of two equal holes at rest (Brill and Lindquist 1963), in the unit of the sum of their bare
masses; the distance falls from 0.9 to 0.5 as that of an inspiral does by gravitational waves (Peters 1964),
and the line turns about the z-axis.  It is a sequence of initial data, no solution of the evolution
equations.  The horizons are found: ah1 and ah2 around each hole, and ah3 around both once the distance is
less than 0.766197428.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evolution_files import Box, Evolution, written_by_command
from isoembed.errors import NoHorizon
from isoembed.relativity import BrillLindquist, StarSurface, find_horizon

FIRST, LAST = 0.9, 0.5  # distances
DURATION = 64.0
STEPS = 32  # iterations in a unit of time
TURN = np.pi  # of the line between the holes
SPACINGS = (0.02, 0.01)  # of the grid around both holes, and of those around each


@dataclass(frozen=True)
class Pair:
    """The slice at a time.

    Attributes
    ----------
    distance : float
    angle : float
        Of the line from the x-axis.
    """

    distance: float
    angle: float

    @classmethod
    def at(cls, time: float) -> "Pair":
        """That at a time from 0 to `DURATION`."""
        left = 1.0 - (1.0 - (LAST / FIRST) ** 4) * time / DURATION
        return cls(FIRST * left**0.25, TURN * (1.0 - left))

    @property
    def positions(self) -> np.ndarray:
        """Those of the holes (2, 3)."""
        line = np.array([np.cos(self.angle), np.sin(self.angle), 0.0])
        return 0.5 * self.distance * np.array([line, -line])

    @property
    def geometry(self) -> BrillLindquist:
        """The slice."""
        return BrillLindquist((0.5, 0.5), self.positions.tolist())

    def horizons(self) -> dict[str, StarSurface]:
        """Those that there are, by their names."""
        # They are found where the line is the z-axis, about which they are symmetric, and turned.
        half = 0.5 * self.distance
        upright = BrillLindquist((0.5, 0.5), ((0.0, 0.0, half), (0.0, 0.0, -half)))
        guesses = {
            "ah1": ((0.0, 0.0, half), 0.2),
            "ah2": ((0.0, 0.0, -half), 0.2),
            "ah3": ((0.0, 0.0, 0.0), 0.6),
        }
        there = {}
        for name, (center, radius) in guesses.items():
            try:
                found = find_horizon(upright, StarSurface.sphere(center, radius)).surface
            except NoHorizon:
                continue
            there[name] = self._turned(found)
        return there

    def _turned(self, surface: StarSurface) -> StarSurface:
        """A surface about the z-axis, turned about the line between the holes."""
        line = self.positions[0] / np.linalg.norm(self.positions[0])
        side = np.array([0.0, 0.0, 1.0])
        turn = np.stack([side, np.cross(line, side), line], axis=1)
        return StarSurface.from_radius(lambda u: surface.radius(u @ turn), turn @ np.array(surface.center))


def write(folder, moments, layout, spacings=SPACINGS):
    """Write all moments; return their times and pairs by iteration."""
    evolution, written = Evolution(Path(folder), layout), {}
    for time in np.linspace(0.0, DURATION, moments):
        iteration = round(time * STEPS)
        pair = Pair.at(iteration / STEPS)
        both = Box((0.0, 0.0, 0.0), 0.75, spacings[0])
        each = [Box(position, 0.3, spacings[1]) for position in pair.positions]
        evolution.add(iteration, iteration / STEPS, pair.geometry, [[both], each])
        for name, surface in pair.horizons().items():
            evolution.add_horizon(name, iteration, iteration / STEPS, surface)
        written[iteration] = pair
    return written


if __name__ == "__main__":
    written_by_command(__doc__, write)
