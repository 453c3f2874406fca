"""Principal eigenvalue of the stability operator, which decides whether a found horizon is stable.

``L psi`` is the change of the expansion for an outward displacement psi of the surface.  The eigenvalue of
least real part is real, with a positive eigenfunction.  A horizon is stable if it is not negative; it is then
a barrier for nearby trapped surfaces.

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

SETTLED = 1e-11  # change of an eigenvalue, relative to its size and 1 / R^2, due to rounding of the operator


def principal_eigenvalue(equations: Equations, areal_radius: float) -> float:
    """Principal eigenvalue of the stability operator of a surface of constant expansion, in 1/length^2.

    Parameters
    ----------
    equations : Equations
        Equations of the surface, neither shifted nor free.
    areal_radius : float

    Notes
    -----
    The eigenvalue is computed in low degrees, then by inverse iteration in all degrees.  A displacement f D
    has the normal component f times the tilt, which gives a generalized eigenvalue problem; the tangential
    part of D has no effect if the expansion is constant.
    """
    low = equations.low
    weights = equations.linear.scale * equations.transform.weights * equations.linear.tilt
    few = low.place[:300]  # larger dense eigenproblems take longer than the inverse iteration
    count = len(few)
    moved = low.values[:, :count].T @ (weights[:, None] * low.values[:, :count])
    values, vectors = eig(equations.matrix()[:count, :count], moved)
    index = int(np.argmin(values.real))
    eigenvalue = float(values[index].real)
    f = np.zeros(equations.transform.harmonics.size)
    f[few] = vectors[:, index].real
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
    """Projection of the normal displacement of f."""
    moved = equations.linear.tilt * equations.transform.values(f[:, None])[:, 0]
    return equations.projected(moved)
