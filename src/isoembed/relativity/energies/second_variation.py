"""Second variation of the Wang-Yau energy in the time function, including the change of the embedding.

The second derivatives are used in Newton's method and to identify minima, which requires few digits: X is
expanded in few harmonics, and the linearized isometry equations for all harmonics of tau are one small dense
system.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from isoembed.arrays import Floats
from isoembed.relativity.energies.wang_yau_functional import EmbeddedTime, Functional, applied, paired, traced
from isoembed.smooth.isometry import normal_solver, strain_rates

COFACTORS = np.array([-1.0, 1.0, -1.0])[:, None]


@dataclass(frozen=True)
class SecondVariation:
    """Second derivatives of E(tau) for tau and X in few harmonics.

    Attributes
    ----------
    functional : Functional
    first, second : ndarray, shapes (n, 2, size), (n, 3, size)
        Derivatives of the harmonics of X along the frames, the second ones covariant on the sphere.
    gradients : ndarray, shape (n, 2, m)
        Gradients of the non-constant harmonics of tau along the frames.
    laplacians : ndarray, shape (n, m)
        Their Laplacians in q.
    """

    functional: Functional
    first: Floats
    second: Floats
    gradients: Floats
    laplacians: Floats

    @classmethod
    def of(cls, functional: Functional) -> SecondVariation:
        """Tables for a functional."""
        f = functional
        each, times = np.eye(f.X.harmonics.size), np.eye(f.tau.harmonics.size)[:, 1:]
        gradients = f.frames @ f.tau.gradients(times)
        drifting = np.einsum("na,nam->nm", f.drift, gradients)
        return cls(
            functional=f,
            first=f.tangents(each),
            second=paired(f.frames, f.X.hessians(each)),
            gradients=gradients,
            laplacians=traced(f.frames, f.tau.hessians(times)) - drifting,
        )

    def at(self, tau: Floats, X: Floats) -> Floats:
        """Second derivatives (m, m) at tau (m,), with the coefficients (size, 3) of X."""
        f, P, turn = self.functional, self.gradients, self.laplacians
        here = EmbeddedTime(f, tau, X)
        slope, shape = here.slope, here.shape
        total = np.einsum("n,nam,nal->ml", f.areas, applied(shape.conjugate, P), P, optimize=True)
        if np.any(tau):
            total += self._response(slope.gradient, X)
        dW = np.einsum("na,nam->nm", slope.gradient, P) / slope.W[:, None]
        turn = turn - (slope.laplacian / slope.W)[:, None] * dW  # -S d theta
        total += (turn.T * (f.areas / slope.S)) @ turn
        weight = f.areas * slope.S / slope.W**2
        total -= np.einsum("n,nam,nal->ml", weight, P, P, optimize=True) - (dW.T * weight) @ dW
        return np.asarray(0.5 * (total + total.T) / (8.0 * np.pi))

    def _response(self, slope: Floats, X: Floats) -> Floats:
        """Part (m, m) from the change of X with tau, for a gradient (n, 2) of tau."""
        f, P = self.functional, self.gradients
        g1, g2 = slope.T[:, :, None]
        strains = np.stack(
            [2.0 * g1 * P[:, 0], np.sqrt(2.0) * (g1 * P[:, 1] + g2 * P[:, 0]), 2.0 * g2 * P[:, 1]]
        )
        change = self._conjugates(X, self._deformations(X, strains))
        flow = applied(change, slope[:, :, None])
        return np.asarray(np.einsum("n,nam,nal->ml", f.areas, flow, P, optimize=True))

    def _deformations(self, X: Floats, strains: Floats) -> Floats:
        """First-order changes (size, 3, m) of X for strains (3, n, m), without rotation."""
        B, root = self.first[:, :, 1:], np.sqrt(self.functional.areas)
        (X1, X2), (first, second) = np.moveaxis(B @ X[1:], 1, 0), root[:, None] * np.moveaxis(B, 1, 0)
        flat = strain_rates(X1, X2, first, second)
        normal = flat.T @ flat
        turns = np.cross(np.eye(3)[:, None], X[None, 1:]).transpose(2, 1, 0).reshape(-1, 3)
        turns = qr(turns, mode="economic")[0]
        normal += np.trace(normal) / len(normal) * turns @ turns.T
        right = flat.T @ (root[:, None] * strains).reshape(len(flat), -1)
        solved = normal_solver(normal)(right)
        changes = np.zeros((len(X), 3, right.shape[1]))
        changes[1:] = solved.reshape(3, len(X) - 1, -1).transpose(1, 0, 2)
        return changes

    def _conjugates(self, X: Floats, changes: Floats) -> Floats:
        """Changes (n, 3, m) of `Shape.conjugate` for changes (size, 3, m) of X."""
        X1, X2 = np.moveaxis(self.first @ X, 1, 0)
        # The conjugate is this sum of second derivatives times the normal N, over N^2.
        bent = COFACTORS * (self.second @ X)[:, ::-1]
        N = np.cross(X1, X2)
        det = np.einsum("nc,nc->n", N, N)[:, None, None]
        flat = changes.reshape(len(changes), -1)
        along, across = np.moveaxis((self.first @ flat).reshape(len(X1), 2, 3, -1), 1, 0)
        dbent = COFACTORS[:, None] * (self.second @ flat).reshape(len(X1), 3, 3, -1)[:, ::-1]
        change = np.einsum("npcm,nc->npm", dbent, N)
        change += np.cross(X2[:, None], bent) @ along + np.cross(bent, X1[:, None]) @ across
        longer = np.cross(X2, N)[:, None] @ along + np.cross(N, X1)[:, None] @ across
        conjugate = np.einsum("npc,nc->np", bent, N)[:, :, None] / det
        return np.asarray((change - 2.0 * conjugate * longer) / det)
