"""A slice with its origin elsewhere."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.relativity.spacetimes.checks import vector
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry


@dataclass(frozen=True)
class Translated:
    """A slice that is moved: what was at the origin is at a center.

    Attributes
    ----------
    geometry : ThreeGeometry
        Such as `KerrSchild`, whose hole is at the origin.  Its messages name points from there.
    center : three floats
    """

    geometry: ThreeGeometry
    center: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector("the center", self.center))

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.geometry.time_symmetric

    @property
    def black_holes(self) -> tuple[tuple[float, Sequence[float]], ...]:
        """The mass and the position of each, where the slice says that."""
        holes = getattr(self.geometry, "black_holes", ())
        return tuple((mass, tuple(np.add(position, self.center).tolist())) for mass, position in holes)

    def metric(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.metric(x - np.array(self.center))

    def gradient(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.gradient(x - np.array(self.center))

    def extrinsic_curvature(self, x: Floats) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.extrinsic_curvature(x - np.array(self.center))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`."""
        return self.geometry.error(lambda slice_: quantity(Translated(slice_, self.center)))

    def deviating(self, x: Floats) -> Iterator[ThreeGeometry]:
        """Slices that this one might be near the points x (n, 3), but for noise; none without any."""
        own = getattr(self.geometry, "deviating", None)
        for slice_ in own(x - np.array(self.center)) if own else ():
            yield Translated(slice_, self.center)
