"""A spherical shell of curved elements, with the data of a closed form at their nodes."""

import numpy as np

from isoembed.relativity.spacetimes.element_grid import Element


def gauss_lobatto(n):
    inner = np.polynomial.legendre.Legendre.basis(n - 1).deriv().roots()
    return np.concatenate([[-1.0], np.sort(inner.real), [1.0]])


def gauss(n):
    return np.polynomial.legendre.leggauss(n)[0]


def wedge(axis, side, a, b, r, center):
    """Points of a part of a cubed sphere, at places (..., 3) in the cube."""
    j, k = [i for i in range(3) if i != axis]

    def at(place):
        tangents = [
            np.tan(low + 0.5 * (place[..., i] + 1.0) * (high - low)) for i, (low, high) in enumerate((a, b))
        ]
        u = np.empty(place.shape)
        u[..., axis], u[..., j], u[..., k] = side, *tangents
        radius = r[0] + 0.5 * (place[..., 2] + 1.0) * (r[1] - r[0])
        return np.array(center) + radius[..., None] * u / np.linalg.norm(u, axis=-1, keepdims=True)

    return at


def shell(geometry, r=(1.6, 2.6), n=(6, 7, 8), nodes=gauss_lobatto, center=(0.0, 0.0, 0.0)):
    """Elements of a shell: six wedges, each in four parts."""
    along = tuple(nodes(count) for count in n)
    place = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1)
    cuts = np.array([-1.0, 0.0, 1.0]) * np.pi / 4
    out = []
    for axis in range(3):
        for side in (1.0, -1.0):
            for p in range(2):
                for q in range(2):
                    points = wedge(axis, side, cuts[p : p + 2], cuts[q : q + 2], r, center)(place)
                    flat = points.reshape(-1, 3)
                    six = np.triu_indices(3)
                    gamma = geometry.metric(flat)[:, *six].reshape(*n, 6)
                    K = geometry.extrinsic_curvature(flat)[:, *six].reshape(*n, 6)
                    out.append(Element(along, points, gamma, None if geometry.time_symmetric else K))
    return out
