"""Thresholds of the studies."""

from dataclasses import dataclass

from isoembed.thresholds import threshold


@dataclass(frozen=True)
class StudyThresholds:
    """Thresholds of the studies."""

    tolerance: float = threshold(1e-6, "mean edge lengths", "Tolerance of the residual, the paper's.")
    fine_tolerance: float = threshold(
        1e-10, "mean edge lengths", "Tolerance of the residual where the error of int H dA is measured."
    )
    exact: float = threshold(
        1e-13, "mean edge lengths", "Tolerance of the residual of two surfaces that have the same lengths."
    )
    same: float = threshold(
        1e-3,
        "mean edge lengths",
        "Surfaces nearer than this are one; other realizations were 70 times farther.",
    )
    same_ergosphere: float = threshold(
        1e-2, "mean edge lengths", "Ergospheres nearer than this are one: the same surface to the eye."
    )
    crumpled: float = threshold(
        0.05, "share of the edges", "A surface is called crumpled from this share of rough edges on."
    )
    kick_iterations: int = threshold(
        150, "count", "Iterations of the damped annealing after the vertices were pushed at random."
    )
    heavy: int = threshold(
        3000, "polygons and markers", "A figure of so many is drawn as pixels, which are a smaller file."
    )


STUDY = StudyThresholds()
