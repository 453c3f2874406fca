"""Images of the unit sphere under a smooth map, from its first and second derivatives."""

from abc import abstractmethod
from functools import cached_property

import numpy as np

from isoembed.arrays import Floats
from isoembed.gallery.quadrature import integrate
from isoembed.gallery.surface import Surface
from isoembed.meshing.sphere import gauss_rule

Images = tuple[Floats, Floats, Floats]


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _frames(u: Floats) -> Floats:
    """Right-handed orthonormal frames a, b, u as an array (3, n, 3), given u (n, 3)."""
    # Branchless and free of cancellation: T. Duff et al., "Building an orthonormal basis, revisited" (2017).
    x, y, z = u.T
    sign = np.copysign(1.0, z)
    p = -1.0 / (sign + z)
    q = x * y * p
    a = np.stack([1.0 + sign * x**2 * p, sign * q, -sign * x], axis=1)
    return np.stack([a, np.stack([q, sign + y**2 * p, -y], axis=1), u])


class MappedSurface(Surface):
    """The image of the unit sphere under an orientation-preserving map X of R^3.

    Only the values on the sphere matter: any smooth extension of X may be used.
    """

    @abstractmethod
    def _differential(self, u: Floats) -> Floats:
        """The matrices dX_i / du_j (n, 3, 3)."""

    @abstractmethod
    def _second_differential(self, u: Floats, normals: Floats) -> Floats:
        """Components of the second derivatives along given vectors: n . d^2 X / du_j du_k (n, 3, 3)."""

    def _images(self, u: Floats) -> Images:
        """Frames a, b, u, their images dX(a), dX(b), dX(u), and the cross product of the first two."""
        frame, D = _frames(u), self._differential(u)
        image = np.asarray(sum(D[:, :, j] * frame[:, :, j, None] for j in range(3)))  # faster than einsum
        return frame, image, np.cross(image[0], image[1])

    def _normals(self, u: Floats) -> Floats:
        cross = self._images(u)[2]
        return cross / np.linalg.norm(cross, axis=1)[:, None]

    def _area_density(self, u: Floats) -> Floats:
        return np.asarray(np.linalg.norm(self._images(u)[2], axis=1))

    def _curvatures(self, u: Floats) -> tuple[Floats, Floats]:
        return self._curvatures_of(u, self._images(u))

    def _curvatures_of(self, u: Floats, images: Images) -> tuple[Floats, Floats]:
        (a, b, _), (x_a, x_b, x_u), cross = images
        density = np.linalg.norm(cross, axis=1)
        normals = cross / density[:, None]
        second = self._second_differential(u, normals)
        second_a, second_b = (np.einsum("nij,nj->ni", second, v) for v in (a, b))
        # Along the great circle u cos t + a sin t, X'' is the second derivative in a minus dX(u).
        height = _dot(normals, x_u)
        e, f, g = height - _dot(a, second_a), -_dot(a, second_b), height - _dot(b, second_b)
        E, F, G = _dot(x_a, x_a), _dot(x_a, x_b), _dot(x_b, x_b)
        return (e * g - f**2) / density**2, (e * G - 2.0 * f * F + g * E) / (2.0 * density**2)

    def _moved(self, u: Floats, displacement: Floats) -> Floats:
        (a, b, _), (x_a, x_b, _), cross = self._images(u)
        along_a, along_b = _dot(displacement, x_a), _dot(displacement, x_b)
        E, F, G = _dot(x_a, x_a), _dot(x_a, x_b), _dot(x_b, x_b)
        step = (G * along_a - F * along_b)[:, None] * a + (E * along_b - F * along_a)[:, None] * b
        moved = u + step / _dot(cross, cross)[:, None]
        return moved / np.linalg.norm(moved, axis=1)[:, None]

    @cached_property
    def _integrals(self) -> Floats:
        def sphere(n: int) -> Floats:
            u, weight = gauss_rule(n, 2 * n)
            u = np.roll(u, 1, axis=1)  # polar axis x, along which long bodies extend
            images = self._images(u)
            cross = images[2]
            element = weight * np.linalg.norm(cross, axis=1)
            volume = weight @ _dot(self._points(u), cross) / 3.0
            return np.array([element.sum(), volume, element @ self._curvatures_of(u, images)[1]])

        return integrate(sphere)
