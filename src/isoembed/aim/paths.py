"""Paths of metrics from the given to the uniform one (paper, sections 2.1 and 2.3)."""

import numpy as np

from isoembed.aim.uniformize import Uniformization
from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter


def path_times(path: str, steps: int, alpha: float) -> Floats:
    """The times t_j / t_f of the pull-back, from 1 (j = 0) to 0 (j = steps), shape (steps + 1,).

    Parameters
    ----------
    path : {"linear", "exponential", "flow"}
        Constant steps, the paper's ``(e^{-alpha Tsteps} - e^{-alpha j}) / (e^{-alpha Tsteps} - 1)``, or
        constant steps along the flow's own history.
    steps : int
        Tsteps.
    alpha : float
        Rate of the exponential path.

    Raises
    ------
    InvalidParameter
        There is no such path, or its steps vanish.
    """
    j = np.arange(steps + 1)
    if path in ("linear", "flow"):
        return 1 - j / steps
    if path == "exponential":
        # 1 at j = 0 and 0 at j = Tsteps, even for tiny alpha.
        times = np.expm1(-alpha * (steps - j)) * np.exp(-alpha * j) / np.expm1(-alpha * steps)
        if not (np.diff(times) < 0).all():
            raise InvalidParameter(
                f"alpha is {alpha}: the {steps} steps of the exponential path become too short to be "
                "distinguished"
            )
        return times
    raise InvalidParameter(f"there is no path {path!r}; there are linear, exponential and flow")


def path_factors(path: str, uniformization: Uniformization, t: float) -> Floats:
    """Conformal factors at t / t_f, shape (V,).

    Linear and exponential paths follow ``u(t) = u(t_f) t / t_f``, Eq. (linlink), at different times; the path
    of the flow uses the factors "produced at each step during Ricci flow".

    Parameters
    ----------
    path : {"linear", "exponential", "flow"}
    uniformization : Uniformization
    t : float
        In [0, 1].
    """
    if path != "flow":
        return uniformization.u * t
    history = uniformization.history
    place = t * (len(history) - 1)
    k = min(int(place), len(history) - 2) if len(history) > 1 else 0
    after = history[min(k + 1, len(history) - 1)]
    return history[k] + (place - k) * (after - history[k])
