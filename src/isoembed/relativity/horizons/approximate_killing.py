"""Approximate Killing vectors of a metric on the sphere.

A field without divergence has a potential z, ``phi^a = eps^ab D_b z``.  Its shear ``D_(a phi_b)``, zero for a
symmetry of the metric, has the square of the trace-free part of ``D_a D_b z``; the fields that make
``int |shear|^2 dA / int |phi|^2 dA`` stationary solve an eigenvalue problem for z [1]_ [2]_ [3]_ [4]_.

References
----------
.. [1] G. B. Cook and B. F. Whiting, "Approximate Killing vectors on S^2", Phys. Rev. D 76 (2007) 041501.
.. [2] G. Lovelace, R. Owen, H. P. Pfeiffer and T. Chu, Phys. Rev. D 78 (2008) 084017, appendix A.
.. [3] R. Owen, "Final remnant of binary black hole mergers: multipolar analysis", Phys. Rev. D 80 (2009)
   084012, which has the norm and the normalization that are used here.
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
    """The three rotations that shear a metric least, at the nodes of a rule on the sphere.

    Their potentials are normalized to ``int z^2 dA = A^3 / (48 pi^2)`` and ``int z dA = 0``, and orthogonal.
    The orbits of a symmetry then close after 2 pi: in its angle phi, dA = dz dphi spreads z evenly from
    -A / 4 pi to A / 4 pi.  On a round sphere they are the rotations about three axes at right angles.

    Attributes
    ----------
    area : float
        A.
    u : ndarray, shape (n, 3)
        The nodes.
    dA : ndarray, shape (n,)
        The area that each stands for, over A / 4 pi.
    potentials : ndarray, shape (n, 3)
        Of the three, over A / 4 pi.
    fields : ndarray, shape (n, 3, 3)
        Velocities of u, tangent vectors: the k-th rotation at [:, k].
    shearing, size : ndarray, shape (3, 3)
        Of their combination with weights c the root of ``A / 4 pi int |shear|^2 dA`` is the length of
        ``shearing @ c``, and that of ``int |phi|^2 dA`` the length of ``size @ c``, both over A / 4 pi.
    harmonics : Harmonics
    coefficients : ndarray, shape (harmonics.size, 3)
        Of the potentials.
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

        0 for a symmetry; sqrt(2) for the fields that come after the rotations on a round sphere.
        """
        return float(np.linalg.norm(self.shearing @ c) / np.linalg.norm(self.size @ c))

    @property
    def least_sheared(self) -> Floats:
        """The weights (3,), of length one, of the rotation that has the least shear of all."""
        weights = np.linalg.solve(self.size, svd(self.shearing @ np.linalg.inv(self.size))[2][-1])
        return np.asarray(weights / np.linalg.norm(weights))

    @property
    def least_shears(self) -> Floats:
        """The stationary values (3,) of the shear, increasing."""
        return np.asarray(svd(self.shearing @ np.linalg.inv(self.size), compute_uv=False)[::-1])


def rotations(metric: TwoMetric, degree: int, axisymmetric: bool) -> Rotations:
    """The rotations that shear a metric least, with potentials in harmonics.

    Raises `InvalidMetric`: the metric is not positive definite.

    Parameters
    ----------
    metric : TwoMetric
    degree : int
        Of the harmonics; the nodes are twice as dense, which leaves as many harmonics to the metric.
    axisymmetric : bool
        The metric is symmetric about the z-axis: it takes a few orders only.

    Notes
    -----
    Of the fields of least shear those are taken whose potentials have the largest means of z u: the others
    are twists, which shear an elongated surface as little.  A last singular value decomposition in their span
    keeps the digits that squares have lost.
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
    # A rotation about the z-axis has order 0, those across it order 1.
    harmonics = Harmonics(degree, min(degree, 1) if axisymmetric else degree)
    Y, first = harmonics.along(u, e)
    Y, first = Y[:, 1:], first[:, :, 1:]  # constants move nothing
    second = harmonics.second_along(u, e)[..., 1:]
    second -= np.einsum("nabc,ncs->nabs", _bend(u, q, e, n), first, optimize=True)
    root = np.sqrt(dA)[:, None, None]
    G = (root * first).reshape(-1, Y.shape[1])
    S = (root * _trace_free(second)).reshape(-1, Y.shape[1])
    # The three rotations are among the eight fields of least shear.
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
    """C^c_ab (n, 2, 2, 2) of ``D_a D_b z = nabla_a nabla_b z - C^c_ab D_c z`` in a frame, by a, b and c.

    D is the derivative of q, nabla that of the unit sphere.
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
    """The trace-free part of symmetric tensors (n, 2, 2, c), as vectors (n, 2, c) of the same norm."""
    return np.stack([second[:, 0, 0] - second[:, 1, 1], 2.0 * second[:, 0, 1]], axis=1) / np.sqrt(2.0)
