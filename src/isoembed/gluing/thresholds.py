"""Thresholds of gluing."""

from dataclasses import dataclass

from isoembed.thresholds import threshold


@dataclass(frozen=True)
class GluingThresholds:
    """Thresholds of gluing, and of the enumeration of gluings."""

    same_length: float = threshold(
        1e-9, "relative", "Difference of one length in coordinates whose digits tell no other."
    )
    rounding: float = threshold(
        1e-15, "perimeters", "Difference that floats leave of one length on two outlines, however short."
    )
    full_angle: float = threshold(
        1e-9, "radians", "Rounding of the sum of angles at a vertex that is still convex."
    )
    equal_sides: float = threshold(
        1e-14, "perimeters", "Sides of an inscribed polygon this close to equal are, up to rounding."
    )
    spacings: int = threshold(
        1000, "count", "Rounds of spacing the corners of an inscribed polygon; each gains a digit or more."
    )


GLUING = GluingThresholds()
