"""Inner horizons: foliation by constant expansion from a horizon inward, through trapped surfaces."""

from __future__ import annotations

import numpy as np

from isoembed.relativity.horizons.newton import FAILURES, NoConvergence, solve
from isoembed.relativity.horizons.normal_image import HIGHEST_DEGREES, NormalImage
from isoembed.relativity.spacetimes.harmonic_map import HarmonicMap
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

LONGEST_STEP = 0.02  # largest mean step, in radii


def foliated_inwards(geometry: ThreeGeometry, start: HarmonicMap) -> NormalImage:
    """End of a foliation by constant expansion from a horizon inward, through trapped surfaces.

    Returns the first leaf whose expansion is not negative, or the last trapped leaf if that is not reached.

    Raises `NoConvergence`, `InvalidMetric` or `InvalidParameter`: the surfaces just inside the horizon are
    not trapped, or the trapped surfaces do not end.
    """
    highest = HIGHEST_DEGREES[int(start.symmetric)]
    map, step, trapped = start, LONGEST_STEP, False
    for _ in range(200):  # leaves
        try:
            inner, expansion = _inside(geometry, map, step * start.radius)
        except FAILURES:
            expansion = np.inf
        if expansion >= 0.0 and trapped and np.isfinite(expansion):
            return NormalImage(inner)
        if expansion >= 0.0:
            step *= 0.5
            # The first step may be shorter than the others.
            if step >= (2e-4 if trapped else 1e-5):
                continue
            if trapped:
                return NormalImage(map)
            raise NoConvergence("the surfaces of constant expansion just inside of it are not trapped")
        map, trapped = inner.reparametrized(), True
        step = min(LONGEST_STEP, 1.5 * step)
        high = map.harmonics.labels[0] > 0.875 * map.degree
        tail = float(np.abs(map.coefficients[high]).max()) / map.radius
        # Large coefficients of high degree require a higher degree.
        if tail > 1e-6 and map.degree < highest:
            map = map.in_degree(min(highest, map.degree * 4 // 3))
    raise NoConvergence("the trapped surfaces inside of it do not end")


def _inside(geometry: ThreeGeometry, map: HarmonicMap, distance: float) -> tuple[HarmonicMap, float]:
    """Surface of constant expansion at a mean distance inside a given one, and its expansion."""
    image = NormalImage(map, map.normals())
    f = np.zeros(image.displacements.size)
    f[0] = -distance * np.sqrt(4.0 * np.pi)
    enough = 1e-5 * distance / map.radius  # intermediate leaves need few digits
    solution = solve(image.discretized(geometry), f, None, enough)
    return image.displaced(solution.iterate.f), solution.expansion
