"""Data of quasi-local energies: the metric of a surface, and how it lies in its slice."""

from collections.abc import Callable
from dataclasses import dataclass

from isoembed.arrays import Floats
from isoembed.smooth.two_metric import TwoMetric


@dataclass(frozen=True)
class SurfaceData:
    """A closed surface in a slice of spacetime, as functions of the direction u on the unit sphere.

    Attributes
    ----------
    metric : TwoMetric
        The metric that the slice induces on the surface.
    mean_curvature : callable, optional
        Takes u (n, 3) and returns ``k = k1 + k2`` (n,) of the surface in the slice, for the outward normal:
        2 / r for a sphere in flat space.
    momentum : callable, optional
        Takes u and returns ``p = K_ij (gamma^ij - n^i n^j)`` (n,), the trace over the surface of the slice's
        extrinsic curvature; the mean curvature vector has the norm ``sqrt(k^2 - p^2)``.  Only its square
        matters.  None where the slice is time-symmetric or p vanishes for another reason.
    normal_momentum : callable, optional
        Takes u and returns ``j = K(., n)``, n the outward normal in the slice, as tangent vectors (n, 3)
        whose products with velocities of u are its values.  None where it vanishes.  Of all energies only
        that of Wang and Yau sees it.
    angular_momentum : float, optional
        J, in units of length^2.
    charge : float
        Q, in units of length.
    marginal : bool
        The surface is a horizon: k^2 = p^2 by definition, whatever the two are by computation.
    relative_error : float
        By how much lengths are uncertain, over the lengths: of data on grids.
    shape : callable, optional
        Takes u and returns the points (n, 3) of the surface in coordinates of the slice that are nearly
        Cartesian: the embedded surface is turned onto them.  None where they are not known: it is turned onto
        the directions.
    name : str
        For reports.
    """

    metric: TwoMetric
    mean_curvature: Callable[[Floats], Floats] | None = None
    momentum: Callable[[Floats], Floats] | None = None
    normal_momentum: Callable[[Floats], Floats] | None = None
    angular_momentum: float | None = None
    charge: float = 0.0
    marginal: bool = False
    relative_error: float = 0.0
    shape: Callable[[Floats], Floats] | None = None
    name: str = ""
