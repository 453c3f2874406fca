"""Regularized continuation: pull-back for negative curvature by a penalty method with weight mu -> 0.

Gauss-Newton steps on the energy of `isoembed.aim.regularized_energy` follow a path of metrics from an
embedded one to the given one.  Both R and K guide the surface; then K is released, and finally R, after it is
replaced by quintics fitted twice, which approximate smooth surfaces better.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from isoembed.aim.acceptance import NEARLY
from isoembed.aim.regularized_energy import RegularizedEnergy
from isoembed.arrays import Floats
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.nonlinear.continuation import extrapolated, penalty_continuation
from isoembed.progress.stages import StageRecorder

BENDING = 3.0  # w along the path
LETTING_GO = (0.3, 0.03, 0.0)  # w at t = 0, in turn
FADE = 0.1  # factor of mu between steps of the release
FADE_STEPS = 15  # afterwards mu has no effect
SHORTEST = 1e-9  # over the length; least length at t = 1, where vertices may coincide


class Continued(NamedTuple):
    """End of the path of metrics, smooth, and the surface after R was released from there, each (V, 3).

    With levels (`isoembed.aim.levels`) R is released along the way, and both are the end of the last.
    """

    smooth: Floats
    vertices: Floats


def log_linear(metric: PolyhedralMetric, start: Floats) -> Callable[[float], Floats]:
    """The lengths ``l(t) = l(0)^{1-t} l(1)^t`` from an embedded metric at t = 1 to the given one at t = 0.

    Linear in the conformal factors u, as the paper's path, as far as the edges are straight.
    """
    a, b = metric.edges.T
    ratio = metric.space.distances(start[a], start[b]) / metric.lengths
    ratio = np.maximum(ratio, SHORTEST)
    return lambda t: metric.lengths * ratio**t


def regularized_continuation(
    energy: RegularizedEnergy,
    start: Floats,
    lengths: Callable[[float], Floats],
    recorder: StageRecorder,
    checkpoint: Mapping[str, NDArray[Any]] | None = None,
) -> Continued:
    """Follow a path of metrics from an embedded one at t = 1, then release the penalty.

    Parameters
    ----------
    energy : RegularizedEnergy
    start : ndarray, shape (V, 3)
        Realization of the metric at t = 1.
    lengths : callable
        Lengths at t, shape (E,), in units of about the mean edge length.
    recorder : StageRecorder
    checkpoint : mapping of str to ndarray, optional
        Checkpoint of an interrupted pull-back.

    Returns
    -------
    Continued
        Unless the path failed, its vertices are close enough to the metric at t = 0 for Newton's method.
    """

    def keep(x: list[Floats], **state: ArrayLike) -> None:
        recorder.keep(x=x, **state)
        recorder.show(vertices=x[-1])

    x, mu = guided(energy, start, lengths, recorder, checkpoint, keep)
    target, close = lengths(0.0), NEARLY * energy.unit
    found, residual = release_penalty(energy.finer(x), x, target, mu, recorder)
    if residual > close:  # edges too long for quintics
        found = min(
            (found, residual), release_penalty(energy, x, target, mu, recorder), key=lambda pair: pair[1]
        )[0]
    return Continued(x, found)


def guided(
    energy: RegularizedEnergy,
    start: Floats,
    lengths: Callable[[float], Floats],
    recorder: StageRecorder,
    checkpoint: Mapping[str, NDArray[Any]] | None = None,
    keep: Callable[..., None] = lambda *_, **__: None,
) -> tuple[Floats, float]:
    """Follow a path of metrics to its end, then release K; return the surface and the last mu.

    Parameters as for `regularized_continuation`; `keep` takes the surfaces reached, in order, and the other
    contents of `checkpoint`.
    """
    target, released = lengths(0.0), 0
    # Mean edge lengths^2; larger values would smooth edges away.
    mu, stiffest = 0.007 * energy.unit**2, 7.0 * energy.unit**2
    history: list[tuple[float, Floats]] = []
    steps = np.linspace(1, 0, 6 + 1).tolist()  # from t = 1 to t = 0
    usual = len(steps) + len(LETTING_GO) + 2 + 4  # usually four steps of the release
    if checkpoint is not None:
        mu = float(checkpoint["mu"])
        history = list(zip(checkpoint["t"].tolist(), checkpoint["x"], strict=True))
        released = int(checkpoint["released"])
        steps = [t for t in steps if t < history[-1][0]]

    def reached() -> None:
        keep([x for _, x in history], t=[t for t, _ in history], mu=mu, released=released)
        recorder.show(done=min(recorder.iterations / usual, 1.0))

    for t in steps:
        recorder.show(t=t)
        guess = extrapolated(history[-3:], t) if history else start
        if not np.isfinite(energy.residuals(guess, lengths(t))).all():  # outside of the hemisphere
            guess = history[-1][1]
        x, downhill = energy.step(guess, lengths(t), mu, BENDING, recorder)
        while not downhill and mu < stiffest:
            mu *= 3.0
            x, downhill = energy.step(guess, lengths(t), mu, BENDING, recorder)
        history = [*history[-2:], (t, x if downhill else guess)]
        reached()
    x = history[-1][1]
    for w in (BENDING, *LETTING_GO)[released:]:
        x = energy.relaxed(x, target, mu, w, recorder)
        history, released = [(0.0, x)], released + 1
        reached()
    mu *= FADE
    return energy.relaxed(x, target, mu, 0.0, recorder), mu


def release_penalty(
    energy: RegularizedEnergy,
    x: Floats,
    lengths: Floats,
    mu: float,
    recorder: StageRecorder,
    *,
    fade: float = FADE,
    is_done: Callable[[], bool] = lambda: False,
) -> tuple[Floats, float]:
    """Release the penalty: decrease mu to zero.

    Parameters
    ----------
    energy : RegularizedEnergy
    x : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    mu : float
        Initial value.
    recorder : StageRecorder
    fade : float
        Factor of mu between steps.
    is_done : callable
        Whether the budget is exhausted, called after each step.

    Returns
    -------
    vertices : ndarray, shape (V, 3)
        The last surface, from which Newton's method converges, or at which mu has no effect any more.
    residual : float
        Its largest residual.
    """
    return penalty_continuation(
        x,
        lambda x, mu: energy.relaxed(x, lengths, mu, 0.0, recorder),
        lambda x: float(np.abs(energy.residuals(x, lengths)).max()),
        mu,
        factor=fade,
        max_weights=FADE_STEPS,
        tolerance=NEARLY * energy.unit,
        exhausted=is_done,
    )
