"""Approximate Killing vectors of a metric on the sphere.

A divergence-free field has a potential z, ``phi^a = eps^ab D_b z``.  Its shear ``D_(a phi_b)`` vanishes for a
Killing vector and has the norm of the trace-free part of ``D_a D_b z``; the stationary points of
``int |shear|^2 dA / int |phi|^2 dA`` solve an eigenvalue problem for z [1]_ [2]_ [3]_ [4]_.

References
----------
.. [1] G. B. Cook and B. F. Whiting, "Approximate Killing vectors on S^2", Phys. Rev. D 76 (2007) 041501.
.. [2] G. Lovelace, R. Owen, H. P. Pfeiffer and T. Chu, Phys. Rev. D 78 (2008) 084017, appendix A.
.. [3] R. Owen, "Final remnant of binary black hole mergers: multipolar analysis", Phys. Rev. D 80 (2009)
   084012, for the norm and the normalization used here.
.. [4] C. Beetle and S. Wilder, "Perturbative stability of the approximate Killing field eigenvalue problem",
   Class. Quantum Grav. 31 (2014) 075009.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, qr, svd

from isoembed.arrays import Floats
from isoembed.meshing.sphere import gauss_rule
from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.transforms import ROUNDING, trimmed
from isoembed.smooth.two_metric import TwoMetric, area_density, orthonormal_frame


@dataclass(frozen=True, eq=False)
class Rotations:
    """Three approximate Killing vectors of least shear, at the nodes of a quadrature rule on the sphere.

    Their potentials are orthogonal and normalized to ``int z^2 dA = A^3 / (48 pi^2)`` and ``int z dA = 0``.
    The orbits of a Killing vector then have period 2 pi: in its angle phi, dA = dz dphi, and z is distributed
    uniformly from -A / 4 pi to A / 4 pi.  On a round sphere they are rotations about three orthogonal axes.

    Attributes
    ----------
    area : float
        Area A.
    u : ndarray, shape (n, 3)
        Nodes, as unit vectors.
    dA : ndarray, shape (n,)
        Area weights of the nodes, in units of A / 4 pi.
    potentials : ndarray, shape (n, 3)
        Potentials of the three fields, in units of A / 4 pi.
    fields : ndarray, shape (n, 3, 3)
        Tangent vectors of the unit sphere; the k-th field is ``fields[:, k]``.
    shearing, size : ndarray, shape (3, 3)
        For the combination with weights c, ``sqrt(A / 4 pi int |shear|^2 dA)`` is the length of
        ``shearing @ c`` and ``sqrt(int |phi|^2 dA)`` that of ``size @ c``, both in units of A / 4 pi.
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Coefficients of the potentials.
    """

    area: float
    u: Floats
    dA: Floats
    potentials: Floats
    fields: Floats
    shearing: Floats
    size: Floats
    harmonics: Harmonics
    coefficients: Floats

    def shear(self, c: Floats) -> float:
        """``sqrt(A / 4 pi int |shear|^2 dA / int |phi|^2 dA)`` of a combination, with weights c (3,).

        0 for a Killing vector; on a round sphere sqrt(2) for the next fields after the rotations.
        """
        return float(np.linalg.norm(self.shearing @ c) / np.linalg.norm(self.size @ c))

    @property
    def weights_of_least_shear(self) -> Floats:
        """Unit vector of weights (3,) of the rotation of least shear."""
        weights = np.linalg.solve(self.size, svd(self.shearing @ np.linalg.inv(self.size))[2][-1])
        return np.asarray(weights / np.linalg.norm(weights))

    @property
    def shears(self) -> Floats:
        """Stationary values (3,) of the shear, in increasing order."""
        return np.asarray(svd(self.shearing @ np.linalg.inv(self.size), compute_uv=False)[::-1])


def rotations(metric: TwoMetric, degree: int, axisymmetric: bool) -> Rotations:
    """Approximate Killing vectors of least shear, with potentials in harmonics.

    Raises `InvalidMetric`: the metric is not positive definite.

    Parameters
    ----------
    metric : TwoMetric
    degree : int
        Degree of the harmonics; the nodes resolve twice this degree, for products with the metric.
    axisymmetric : bool
        Whether the metric is symmetric about the z-axis, so that orders up to 1 suffice.

    Notes
    -----
    Among the fields of least shear, those with the largest means of z u are selected: the others are twists,
    which have a comparably small shear on an elongated surface.  A singular value decomposition in their span
    recovers the digits lost in the normal equations.
    """
    n = 2 * degree
    u, weights = gauss_rule(n, 16 if axisymmetric else 2 * n)  # enough angles for order 1
    q = metric.tensor(u)
    density = area_density(q)
    area = float(weights @ density)
    unit = area / (4.0 * np.pi)
    dA = weights * (density / unit)
    q = q / unit
    e = orthonormal_frame(u, q)
    # A rotation about the z-axis has order 0, rotations about axes orthogonal to it order 1.
    harmonics = Harmonics(degree, min(degree, 1) if axisymmetric else degree)
    Y, first = harmonics.along(u, e)
    Y, first = Y[:, 1:], first[:, :, 1:]  # a constant potential has no field
    second = harmonics.second_along(u, e)[..., 1:]
    second -= np.einsum("nabc,ncs->nabs", _bend(u, q, e, n), first, optimize=True)
    root = np.sqrt(dA)[:, None, None]
    G = (root * first).reshape(-1, Y.shape[1])
    S = (root * _trace_free(second)).reshape(-1, Y.shape[1])
    # Degrees 1 and 2 on the round sphere: the rotations are among these eight fields.
    _, found = eigh(S.T @ S, G.T @ G, subset_by_index=[0, 7])
    z = Y @ found
    means = dA @ z / (4.0 * np.pi)
    z -= means
    root = np.sqrt(dA)[:, None]
    moments = np.linalg.norm(z.T @ (dA[:, None] * u), axis=1) / np.linalg.norm(root * z, axis=0)
    three = np.argsort(moments)[-3:]
    basis = np.linalg.inv(qr(root * z[:, three], mode="r")[0][:3]) * np.sqrt(4.0 * np.pi / 3.0)
    found = found[:, three] @ basis
    coefficients = np.vstack([-np.sqrt(4.0 * np.pi) * means[three] @ basis, found])
    slope = first @ found
    fields = e[:, 0, :, None] * slope[:, 1, None, :] - e[:, 1, :, None] * slope[:, 0, None, :]
    shearing, size = (qr(part @ found, mode="r")[0][:3] for part in (S, G))
    return Rotations(area, u, dA, z[:, three] @ basis, fields, shearing, size, harmonics, coefficients)


def _bend(u: Floats, q: Floats, e: Floats, heights: int) -> Floats:
    """Difference tensor C^c_ab (n, 2, 2, 2) at [:, a, b, c], in a frame.

    ``D_a D_b z = nabla_a nabla_b z - C^c_ab D_c z``, with D the connection of q and nabla that of the sphere.
    """
    around = len(u) // heights
    harmonics = Harmonics(heights - 1, min(heights, around // 2) - 1)
    coefficients = SphereTransform(harmonics, heights, around).analysis(q.reshape(len(u), 9))
    needed = np.abs(coefficients).max(axis=1) > ROUNDING * np.abs(q).max()
    coefficients, harmonics = trimmed(coefficients, harmonics, needed)
    gradients = harmonics.derivatives(u, coefficients)[1].reshape(len(u), 3, 3, 3)
    along = np.einsum("nak,nijk->naij", e, gradients)
    D = e[:, None] @ along @ e[:, None].transpose(0, 1, 3, 2)  # (nabla_a q)_bc
    return np.asarray(0.5 * (D + D.transpose(0, 2, 1, 3) - D.transpose(0, 2, 3, 1)))


def _trace_free(second: Floats) -> Floats:
    """Trace-free part of symmetric tensors (n, 2, 2, c), as vectors (n, 2, c) of the same norm."""
    return np.stack([second[:, 0, 0] - second[:, 1, 1], 2.0 * second[:, 0, 1]], axis=1) / np.sqrt(2.0)
