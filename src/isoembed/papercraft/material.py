"""Material and machine of a net: joints, allowances, kerf, perforated folds, thickness."""

import math
from dataclasses import dataclass, fields
from typing import Literal, get_args

from isoembed.errors import InvalidParameter
from isoembed.gluing.polygon import is_number

Joints = Literal["tabs", "stitches", "none"]
Bends = Literal["score", "perforate"]
Surface = Literal["outside", "inside"]


@dataclass(frozen=True, kw_only=True)
class Material:
    """Material of a net and cutting parameters, in millimeters.

    Parameters
    ----------
    joints : {"tabs", "stitches", "none"}
        Joints of the sides: glue tabs; stitching holes, equally many on both sides, on the side itself if
        there is an allowance and `spacing` inside it otherwise; or edge to edge.
    allowance : float
        Seam allowance of cloth or leather: distance of the cut from the outline of the net, which is the
        seam.  Corners sharper than a right angle are cut off.  Not allowed with tabs.
    spacing : float
        Spacing of stitching holes.
    hole : float
        Diameter of stitching holes.
    kerf : float
        Width of the beam or blade; outlines are offset outward by half of it, and holes inward.
    bends : {"score", "perforate"}
        Cutting of folds: as a whole line for scoring, or as dashes with material at both ends.
    dash, gap : float
        Length of the cuts of a perforated fold, and smallest gap between them.
    thickness : float
        Thickness of board, foam or metal, for which the faces are shortened where they meet; see
        `isoembed.papercraft.thickness.thickened`.
    surface : {"outside", "inside"}
        Surface of the thick sheet that coincides with the faces of the solid.
    k_factor : float
        Position of the neutral line of a bend in the thickness, from 0 at the inside to 1.
    radius : float
        Inside radius of bends.
    """

    joints: Joints = "tabs"
    allowance: float = 0.0
    spacing: float = 4.0
    hole: float = 1.0
    kerf: float = 0.0
    bends: Bends = "score"
    dash: float = 3.0
    gap: float = 1.0
    thickness: float = 0.0
    surface: Surface = "outside"
    k_factor: float = 0.5
    radius: float = 0.0

    def __post_init__(self) -> None:
        for name, kind in (("joints", Joints), ("bends", Bends), ("surface", Surface)):
            choices = get_args(kind)
            if getattr(self, name) not in choices:
                raise InvalidParameter(f"{name} is {getattr(self, name)!r}, not one of {', '.join(choices)}")
        positive = ("spacing", "hole", "dash", "gap")
        for name in (field.name for field in fields(self) if field.type is float):
            value = getattr(self, name)
            bound = "above 0" if name in positive else "of at least 0"
            if not is_number(value) or not 0 <= value < math.inf or (name in positive and value == 0):
                text = f"{value:g}" if is_number(value) else repr(value)
                raise InvalidParameter(f"{name} is {text}, not a number {bound}")
        if self.allowance and self.joints == "tabs":
            raise InvalidParameter(
                f"an allowance of {self.allowance:g} mm is for joints='stitches' or joints='none'"
            )
        if self.k_factor > 1:
            raise InvalidParameter(f"k_factor is {self.k_factor:g}, not from 0 to 1")
        for name, is_cut in (("hole", self.joints == "stitches"), ("dash", self.bends == "perforate")):
            if is_cut and self.kerf >= getattr(self, name):
                raise InvalidParameter(
                    f"kerf is {self.kerf:g} mm, as wide as a {name} of {getattr(self, name):g} mm"
                )
