"""Regularized continuation: pull-back for negative curvature by a penalty method with weight mu -> 0.

It follows the metrics from an embedded one to the given one by Gauss-Newton steps on the energy of
`isoembed.aim.regularized_energy`.  Both R and K lead the surface there; then K is let go, and then R, after
its place was taken by quintics fitted twice, which know smooth surfaces better still.
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

BENDING = 3.0  # w on the way
LETTING_GO = (0.3, 0.03, 0.0)  # w at t = 0, in turn
FADE = 0.1  # factor of mu from step to step as a surface is let go
FADE_STEPS = 15  # after them mu has no effect
SHORTEST = 1e-9  # lengths: the least length at t = 1, where vertices may coincide


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
    kept: Mapping[str, NDArray[Any]] | None = None,
) -> Continued:
    """Follow a path of metrics from an embedded one at t = 1, then let go of what guides.

    Parameters
    ----------
    energy : RegularizedEnergy
    start : ndarray, shape (V, 3)
        Realizes the metric at t = 1.
    lengths : callable
        The lengths at t, shape (E,), in units of the mean edge length or so.
    recorder : StageRecorder
    kept : mapping of str to ndarray, optional
        What an interrupted pull-back kept, to go on from.

    Returns
    -------
    Continued
        Its vertices are, where it did not get lost, near enough to the metric at t = 0 for Newton's method.
    """

    def keep(x: list[Floats], **state: ArrayLike) -> None:
        recorder.keep(x=x, **state)
        recorder.show(vertices=x[-1])

    x, mu = guided(energy, start, lengths, recorder, kept, keep)
    given, close = lengths(0.0), NEARLY * energy.unit
    found, residual = release_penalty(energy.finer(x), x, given, mu, recorder)
    if residual > close:  # edges too long for quintics to know the surface
        found = min(
            (found, residual), release_penalty(energy, x, given, mu, recorder), key=lambda pair: pair[1]
        )[0]
    return Continued(x, found)


def guided(
    energy: RegularizedEnergy,
    start: Floats,
    lengths: Callable[[float], Floats],
    recorder: StageRecorder,
    kept: Mapping[str, NDArray[Any]] | None = None,
    keep: Callable[..., None] = lambda *_, **__: None,
) -> tuple[Floats, float]:
    """Follow a path of metrics to its end, then let K go; the surface, and the last mu.

    The parameters are those of `regularized_continuation`; `keep` takes the surfaces reached, the
    last one last, and what else `kept` is to hold.
    """
    given, released = lengths(0.0), 0
    # Mean edge lengths^2; more would smooth edges away.
    mu, stiffest = 0.007 * energy.unit**2, 7.0 * energy.unit**2
    known: list[tuple[float, Floats]] = []
    steps = np.linspace(1, 0, 6 + 1).tolist()  # from t = 1 to t = 0
    usual = len(steps) + len(LETTING_GO) + 2 + 4  # four steps let go, as a rule
    if kept is not None:
        mu, known = float(kept["mu"]), list(zip(kept["t"].tolist(), kept["x"], strict=True))
        released = int(kept["released"])
        steps = [t for t in steps if t < known[-1][0]]

    def reached() -> None:
        keep([x for _, x in known], t=[t for t, _ in known], mu=mu, released=released)
        recorder.show(done=min(recorder.iterations / usual, 1.0))

    for t in steps:
        recorder.show(t=t)
        guess = extrapolated(known[-3:], t) if known else start
        if not np.isfinite(energy.residuals(guess, lengths(t))).all():  # it has left the half of the sphere
            guess = known[-1][1]
        x, downhill = energy.step(guess, lengths(t), mu, BENDING, recorder)
        while not downhill and mu < stiffest:
            mu *= 3.0
            x, downhill = energy.step(guess, lengths(t), mu, BENDING, recorder)
        known = [*known[-2:], (t, x if downhill else guess)]
        reached()
    x = known[-1][1]
    for w in (BENDING, *LETTING_GO)[released:]:
        x = energy.relaxed(x, given, mu, w, recorder)
        known, released = [(0.0, x)], released + 1
        reached()
    mu *= FADE
    return energy.relaxed(x, given, mu, 0.0, recorder), mu


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
    """Let mu vanish.

    Parameters
    ----------
    energy : RegularizedEnergy
    x : ndarray, shape (V, 3)
    lengths : ndarray, shape (E,)
    mu : float
        Of the first step.
    recorder : StageRecorder
    fade : float
        Factor of mu from step to step.
    is_done : callable
        Whether no more may be spent, asked after each step.

    Returns
    -------
    vertices : ndarray, shape (V, 3)
        The last surface: where Newton's method does not get lost, or mu has no effect any more.
    residual : float
        Its largest.
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
