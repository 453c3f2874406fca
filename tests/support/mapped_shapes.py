"""Closed surfaces that no center sees all of, as maps of the unit sphere."""

import numpy as np

from isoembed.meshing.sphere import fibonacci_directions, hull_faces


def banana(u, spine=1.5, axes=(3.0, 0.8, 0.7)):
    """An ellipsoid bent around a circle with this radius in the x-z plane."""
    x, y, z = (u * axes).T
    angle = x / spine
    return np.stack([(spine + z) * np.sin(angle), y, (spine + z) * np.cos(angle)], axis=1)


def bowl(u, spine=1.4, axes=(2.4, 2.4, 0.5)):
    """A flat spheroid bent around a sphere with this radius."""
    x, y, z = (u * axes).T
    angle = np.hypot(x, y) / spine
    side = (spine + z) * np.sinc(angle / np.pi) / spine
    return np.stack([side * x, side * y, (spine + z) * np.cos(angle)], axis=1)


def peanut(u):
    """Two balls with a waist, along x."""
    return (0.5 + 1.5 * u[:, :1] ** 2) * u


def ellipsoid(u):
    """The ellipsoid with the axes 3, 2 and 1."""
    return u * [3.0, 2.0, 1.0]


def differences(shape, u, step=2.0**-11):
    """The unit normals (n, 3) and mean curvatures k1 + k2 (n,) of a shape in flat space.

    By differences of sixth order in a chart at each direction, to about 1e-9.
    """
    e = np.cross(u, np.where(np.abs(u[:, 2:]) < 0.7, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]))
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    f = np.cross(u, e)

    def at(a, b):
        """The shape in a chart of the plane."""
        v = u + a * e + b * f
        return shape(v / np.linalg.norm(v, axis=1, keepdims=True))

    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    bends = {0: -49 / 18, 1: 3 / 2, 2: -3 / 20, 3: 1 / 90}

    def slope(direction):
        return sum(w * (direction(n * step) - direction(-n * step)) for n, w in weights.items()) / step

    def bend(direction):
        return (
            sum(
                w * (direction(n * step) + direction(-n * step)) * (0.5 if n == 0 else 1.0)
                for n, w in bends.items()
            )
            / step**2
        )

    X1, X2 = slope(lambda a: at(a, 0.0)), slope(lambda b: at(0.0, b))
    uu, vv = bend(lambda a: at(a, 0.0)), bend(lambda b: at(0.0, b))
    uv = 0.5 * (bend(lambda a: at(a, a)) - uu - vv)
    n = np.cross(X1, X2)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    dot = lambda a, b: np.einsum("ni,ni->n", a, b)  # noqa: E731
    E, F, G = dot(X1, X1), dot(X1, X2), dot(X2, X2)
    return n, -(E * dot(vv, n) - 2 * F * dot(uv, n) + G * dot(uu, n)) / (E * G - F**2)


def mesh(shape, n, seed=0, irregular=0.3):
    """Vertices (n, 3) on a shape, the triangles between them, and the directions that they are images of."""
    u = fibonacci_directions(n)
    u = u + irregular / np.sqrt(n) * np.random.default_rng(seed).normal(size=(n, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return shape(u), hull_faces(u), u
