"""Thresholds of the cited methods and of their comparison."""

from dataclasses import dataclass

from isoembed.thresholds import threshold


@dataclass(frozen=True)
class BaselineThresholds:
    """Thresholds of the cited methods and of their comparison."""

    tolerance: float = threshold(1e-10, "mean edge lengths", "Tolerance of the residual, as of `embed`.")
    arrived: float = threshold(
        1e-6, "diameters", "A surface so near to the true one is that, and a residual so small is none."
    )
    worse: float = threshold(2.0, "relative", "Strains over the least one that are not due to the degree.")
    resolved: float = threshold(
        1e-5, "relative", "Strains whose squares a minimizer cannot tell apart much longer."
    )
    determined: int = threshold(2, "count", "Vertices for a harmonic at least.")
    floor: float = threshold(
        1e-9,
        "mean edge lengths",
        "Residuals of the embedding flow below this are no more of the steps alone.",
    )
    wire_steps: int = threshold(200, "count", "Steps of Levenberg and Marquardt's method.")
    minimizer_iterations: int = threshold(1500, "count", "Iterations of L-BFGS.")
    minimizer_memory: int = threshold(20, "count", "Steps that L-BFGS remembers.")
    flat: float = threshold(1e-15, "of the sum of squares", "A decrease in L-BFGS below this is none.")
    dense: int = threshold(
        4,
        "nodes a degree",
        "Heights of nodes for the Gaussian curvature, which varies faster than the metric.",
    )
    newton_steps: int = threshold(30, "count", "Newton steps to the conformal factor.")
    settled: float = threshold(1e-9, "conformal factor", "Change in a Newton step at which they end.")


BASELINES = BaselineThresholds()
