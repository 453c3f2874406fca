"""Stability: principal eigenvalue of the stability operator.

``L psi`` is the change of the expansion when the surface moves outward by psi.  Of its eigenvalues the one
with the least real part is real, and has a positive eigenfunction: a horizon is stable where it is not
negative, and a barrier that trapped surfaces nearby do not cross.

References
----------
Andersson, Mars and Simon, Phys. Rev. Lett. 95 (2005) 111102; Adv. Theor. Math. Phys. 12 (2008) 853.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import eig

from isoembed.arrays import Floats
from isoembed.relativity.horizons.discretization import Equations

SETTLED = 1e-11  # change of an eigenvalue, over its size and 1 / R^2, that is rounding of the operator


def principal_eigenvalue(equations: Equations, areal_radius: float) -> float:
    """The least eigenvalue of the stability operator of a surface of constant expansion, in 1/length^2.

    Parameters
    ----------
    equations : Equations
        Those of the surface; neither shifted nor free.
    areal_radius : float

    Notes
    -----
    It is found in low degrees, and then by inverse iteration in all.  A displacement f D moves the surface
    outward by f times the tilt, so that the eigenvalue problem is a generalized one; the part of D along the
    surface does nothing where the expansion is constant.
    """
    low = equations.low
    weights = equations.linear.scale * equations.transform.weights * equations.linear.tilt
    few = low.place[:300]  # all eigenvalues of more would take longer than the inverse iteration
    count = len(few)
    moved = low.values[:, :count].T @ (weights[:, None] * low.values[:, :count])
    values, vectors = eig(equations.matrix()[:count, :count], moved)
    least = int(np.argmin(values.real))
    eigenvalue = float(values[least].real)
    f = np.zeros(equations.transform.harmonics.size)
    f[few] = vectors[:, least].real
    if len(f) == count:
        return eigenvalue
    f /= np.linalg.norm(f)
    for _ in range(6):  # inverse iteration
        shifted = replace(equations, shift=eigenvalue)
        moved = _moved(shifted, f)
        new = shifted.solved(moved)
        change = float(f @ f / (f @ new))
        eigenvalue += change
        f = new / np.linalg.norm(new)
        if abs(change) * areal_radius**2 <= SETTLED:
            break
    return eigenvalue


def _moved(equations: Equations, f: Floats) -> Floats:
    """The projection of how far f moves the surface outward."""
    moved = equations.linear.tilt[:, None] * equations.transform.values(f[:, None])
    return equations.projected(moved)[:, 0]
