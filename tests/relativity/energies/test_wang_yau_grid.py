"""Energies of a surface without symmetry around two holes in motion, in a slice on a Cartesian grid."""

import numpy as np
import pytest

from isoembed.relativity import (
    BoostedSchwarzschild,
    CartesianGrid,
    StarSurface,
    Superposed,
    embed_surface,
    wang_yau,
)

HOLES = Superposed(
    [
        BoostedSchwarzschild(1.0, (0.0, 0.2, 0.3), (0.3, 0.0, -0.9)),
        BoostedSchwarzschild(0.6, (0.1, -0.3, -0.2), (-0.4, 0.2, 1.1)),
    ]
)
CENTER = (0.2, -0.1, 0.3)


def radius(u):
    x, y, z = u.T
    return 4.5 * (1.0 + 0.05 * x * y + 0.04 * z**3 - 0.05 * (x**4 - y**3 * z) + 0.03 * x)


def sampled(spacing):
    """The slice on a grid of this spacing."""
    axes = [np.arange(center - 6.0, center + 6.0 + spacing, spacing) for center in CENTER]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    flat = x.reshape(-1, 3)
    gamma, K = (
        tensor(flat).T.reshape(3, 3, *x.shape[:3]) for tensor in (HOLES.metric, HOLES.extrinsic_curvature)
    )
    return CartesianGrid(x[0, 0, 0], spacing, gamma, K)


@pytest.mark.slow
def test_errors_of_a_slice_on_a_grid():
    surface = StarSurface.from_radius(radius, center=CENTER)
    assert surface.harmonics.degree == 4
    true = embed_surface(surface.data(HOLES), vertices=100)
    least = wang_yau(true.data, "optimal", embedding=true.embedding, degrees=(2,)).energy
    assert least.value < true.energies.brown_york.value < true.energies.liu_yau.value
    off = {}
    for spacing in (0.54, 0.36):
        data = surface.data(sampled(spacing))
        found = embed_surface(data, start=true)
        pairs = [
            (found.energies.brown_york, true.energies.brown_york),
            (found.energies.liu_yau, true.energies.liu_yau),
            (wang_yau(data, "optimal", embedding=found.embedding, degrees=(2,)).energy, least),
        ]
        off[spacing] = max(abs(one.value - other.value) for one, other in pairs)
        assert all(abs(one.value - other.value) < one.error for one, other in pairs)
    # The eighth power of 1.5 is 26, the seventh 17.
    assert off[0.36] < 3e-6 and off[0.54] > 10.0 * off[0.36]
