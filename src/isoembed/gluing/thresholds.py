"""Thresholds of gluing."""

from dataclasses import dataclass

from isoembed.thresholds import threshold


@dataclass(frozen=True)
class GluingThresholds:
    """Thresholds of gluing, and of the enumeration of gluings."""

    same_length: float = threshold(
        1e-9,
        "relative",
        "Difference of equal lengths, unless the digits of the coordinates imply another.",
    )
    rounding: float = threshold(
        1e-15, "perimeters", "Rounding error of a length on two outlines, however short."
    )
    full_angle: float = threshold(1e-9, "radians", "Rounding error of the angle sum at a convex vertex.")
    equal_sides: float = threshold(
        1e-14, "perimeters", "Rounding error of equal sides of an inscribed polygon."
    )
    spacings: int = threshold(
        1000,
        "count",
        "Iterations that space the corners of an inscribed polygon, each gaining a digit or more.",
    )


GLUING = GluingThresholds()
