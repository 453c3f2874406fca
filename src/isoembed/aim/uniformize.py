"""Uniformization (paper, section 2.1): conformal factors that make the Gaussian curvature constant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_array, diags_array

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric
from isoembed.linalg import SingularMatrix, factor_general
from isoembed.metric.conformal import rescaled
from isoembed.metric.conformal_sphere import conformal_factors, conformal_sphere
from isoembed.metric.curvature import area, deficits, dual_areas
from isoembed.metric.delaunay import delaunay
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.metric.variation import (
    area_derivative,
    deficit_derivative,
    dual_area_derivative,
    length_derivative,
)
from isoembed.nonlinear.acceptance import LineSearch
from isoembed.nonlinear.descent import Curve, descend
from isoembed.progress.stages import StageRecorder

MAX_STEPS = 30  # Newton steps


@dataclass(frozen=True)
class Uniformization:
    """Conformal factors from the given metric to one of constant curvature.

    Attributes
    ----------
    u : ndarray, shape (V,)
        The u_a(t_f) of Eq. (len).
    metric : PolyhedralMetric
        rho_{t_f}.
    history : ndarray, shape (n, V)
        u at the steps of the flow from t = 0 to t_f; by Newton's method, the two ends.
    deviation : float
        Root mean square of ``k_a / kbar - 1``.
    converged : bool
        Whether the method's criterion was met.
    """

    u: Floats
    metric: PolyhedralMetric
    history: Floats
    deviation: float
    converged: bool

    @property
    def kbar(self) -> float:
        """``2 pi chi / A`` of the uniform metric."""
        return 4 * np.pi / area(self.metric)

    @property
    def radius(self) -> float:
        """``r = 1 / sqrt(kbar)``, Eq. (avg)."""
        return float(1 / np.sqrt(self.kbar))


def ricci_flow(
    metric: PolyhedralMetric, recorder: StageRecorder, *, integrator: str, epsilon: float, t_f: float
) -> Uniformization:
    """Integrate ``du_a/dt = -(k_a - kbar)``, Eq. (ricci), kbar = 2 pi chi / A.

    Parameters
    ----------
    metric : PolyhedralMetric
        rho_0.
    recorder : StageRecorder
        Recorder of right-hand sides, as iterations, and of the integrator's factorizations.
    integrator : {"BDF", "Radau", "RK45", "RK23", "DOP853", "LSODA"}
        A method of `scipy.integrate.solve_ivp`.  The flow is stiff: explicit ones take thousands of steps.
    epsilon : float
        Stop when the root mean square of ``k_a / kbar - 1`` is below it.
    t_f : float
        Stop at this time at the latest, in units of ``1 / kbar`` of the given metric.

    Returns
    -------
    Uniformization
        Not converged if the flow ended first, or needed more than 20,000 right-hand sides, with u = 0.
    """
    n = metric.triangulation.n_vertices
    flow = _RicciFlow(metric, recorder, epsilon)
    at_once = _deviation(metric)
    if at_once < epsilon:
        return Uniformization(np.zeros(n), metric, np.zeros((1, n)), at_once, True)
    try:
        solution: Any = solve_ivp(
            flow.velocity,
            (0.0, t_f * flow.time_unit),
            np.zeros(n),
            method=integrator,
            events=flow.until_uniform,
            rtol=1e-4,
            atol=1e-6,
            **({"jac": flow.jacobian} if integrator in ("BDF", "Radau") else {}),
        )
    except _Exhausted:
        return Uniformization(np.zeros(n), metric, np.zeros((1, n)), at_once, False)
    recorder.factorizations += int(solution.nlu)
    end = solution.y_events[0][-1] if solution.status == 1 else solution.y[:, -1]
    history = np.vstack([solution.y[:, :-1].T, end])
    while (rho := flow.metric_at(history[-1])) is None:  # the given metric is the first
        history = history[:-1]
    return Uniformization(history[-1], rho, history, _deviation(rho), solution.status == 1)


@dataclass(frozen=True, eq=False)
class _RicciFlow:
    """The flow from a metric, in the form of `solve_ivp`, with the state u, shape (V,)."""

    metric: PolyhedralMetric
    recorder: StageRecorder
    epsilon: float

    @property
    def time_unit(self) -> float:
        """``1 / kbar`` of the given metric."""
        return area(self.metric) / (4 * np.pi)

    def metric_at(self, u: Floats) -> PolyhedralMetric | None:
        """The metric at a state of the integrator, if it exists."""
        if not np.abs(u).max() < 300.0:  # squared exponentials would overflow
            return None
        try:
            return rescaled(self.metric, u)
        except InvalidMetric:
            return None

    def velocity(self, _time: float, u: Floats) -> Floats:
        """``kbar - k_a``; NaN if there is no metric, so that the integrator takes a shorter step."""
        self.recorder.iterations += 1
        if self.recorder.iterations > 20_000:  # right-hand sides of the flow
            raise _Exhausted
        rho = self.metric_at(u)
        excess = np.full(len(u), np.nan)
        if rho is not None:
            excess = deficits(rho) / dual_areas(rho) - 4 * np.pi / area(rho)
        self.recorder.show(residual=float(np.abs(excess).max() * self.time_unit))
        return -excess

    def jacobian(self, _time: float, u: Floats) -> csr_array:
        """The derivative of the velocity without that of kbar, which is dense."""
        rho = self.metric_at(u)
        if rho is None:
            return csr_array((len(u), len(u)))
        dual = dual_areas(rho)
        by_length = deficit_derivative(rho) - diags_array(deficits(rho) / dual) @ dual_area_derivative(rho)
        return csr_array(-(diags_array(1 / dual) @ by_length @ length_derivative(self.metric, u)))

    @property
    def until_uniform(self) -> Callable[[float, Floats], float]:
        """Event function of the flow, with a sign change at its end."""

        def excess(_time: float, u: Floats) -> float:
            rho = self.metric_at(u)
            return (np.inf if rho is None else _deviation(rho)) - self.epsilon

        excess.terminal = True  # type: ignore[attr-defined]
        return excess


class _Exhausted(Exception):  # noqa: N818 - a signal through the integrator, caught above
    """The integrator needs too many right-hand sides."""


def newton_uniformization(
    metric: PolyhedralMetric, recorder: StageRecorder, *, epsilon: float
) -> Uniformization:
    """Solve ``epsilon_a - kbar A*_a = 0``, the flow's fixed point, by Newton's method.

    On the sphere the solutions form a family related by Moebius maps, from which the discrete equation barely
    selects one.  The three Moebius modes, the coordinates of a conformal layout on the sphere, are therefore
    projected out: u moves orthogonally to them, starting from the factors of the centered layout, and the
    equation holds up to their multiples, which are small of second order.

    Parameters
    ----------
    metric : PolyhedralMetric
        rho_0.
    recorder : StageRecorder
    epsilon : float
        Stop when the root mean square of ``k_a / kbar - 1``, without the Moebius modes, is below it.

    Returns
    -------
    Uniformization
        With the area of the given metric.
    """
    triangles = delaunay(metric.normalized)
    sphere = conformal_sphere(triangles, recorder)
    C = np.column_stack([np.ones(len(sphere.points)), sphere.points])
    state = _start(metric, conformal_factors(triangles.normalized, sphere), C)

    def step(state: _State) -> Curve[_State]:
        recorder.show(residual=state.deviation)
        du = _newton_step(metric, state, C, recorder)
        recorder.iterations += 1
        return lambda fraction: _State.at(metric, state.u + fraction * du, C)

    found = descend(
        state,
        step,
        LineSearch(decrease=0.0, shortest=1e-3),
        value=lambda state: state.deviation,
        converged=lambda _, deviation, __: deviation < epsilon,
        max_iterations=MAX_STEPS,
    )
    return _finished(metric, found.point, found.converged)


@dataclass(frozen=True)
class _State:
    """Conformal factors, and the deviation of their metric from uniformity without the modes C."""

    u: Floats
    rho: PolyhedralMetric
    F: Floats
    dual: Floats
    deviation: float

    @classmethod
    def at(cls, metric: PolyhedralMetric, u: Floats, C: Floats) -> _State:
        # A factor common to all lengths changes nothing: keep the area, as the flow does.
        u = u + np.log(area(metric) / area(rescaled(metric, u))) / 2
        rho = rescaled(metric, u)
        dual = dual_areas(rho)
        kbar = 4 * np.pi / area(rho)
        F = deficits(rho) - kbar * dual
        M = np.abs(dual)[:, None]
        rest = F - (M * C) @ np.linalg.solve(C.T @ (M * C), C.T @ F)
        return cls(u, rho, F, dual, float(np.sqrt(np.mean((rest / (kbar * dual)) ** 2))))


def _start(metric: PolyhedralMetric, u: Floats, C: Floats) -> _State:
    """Halve the conformal factors u until their metric exists."""
    while True:
        try:
            return _State.at(metric, u, C)
        except InvalidMetric:
            u = u / 2


def _newton_step(metric: PolyhedralMetric, state: _State, C: Floats, recorder: StageRecorder) -> Floats:
    """Solve ``(dF/du) du + M C lambda = -F``, ``C^T M du = 0``."""
    rho, F, dual = state.rho, state.F, state.dual
    kbar = 4 * np.pi / area(rho)
    by_u = length_derivative(metric, state.u)
    S = (deficit_derivative(rho) - kbar * dual_area_derivative(rho)) @ by_u
    g = by_u.T @ area_derivative(rho)  # kbar depends on the area: dF/du = S + (kbar / A) A* g^T
    modes = np.abs(dual)[:, None] * C
    try:
        factor = factor_general(S, recorder.work)
    except SingularMatrix:
        return np.zeros(len(F))
    solved = factor.solve(np.column_stack([F, dual * kbar / area(rho), modes]))
    plain, responses = solved[:, 0], solved[:, 1:]
    # Unknowns: g^T du, lambda.
    border = np.vstack([g, modes.T])
    K = border @ responses
    K[0, 0] += 1.0
    return -plain + responses @ np.linalg.lstsq(K, border @ plain, rcond=None)[0]


def _finished(metric: PolyhedralMetric, state: _State, converged: bool) -> Uniformization:
    history = np.vstack([np.zeros_like(state.u), state.u])
    return Uniformization(state.u, state.rho, history, _deviation(state.rho), converged)


def _deviation(rho: PolyhedralMetric) -> float:
    kbar = 4 * np.pi / area(rho)
    return float(np.sqrt(np.mean((deficits(rho) / (kbar * dual_areas(rho)) - 1) ** 2)))
