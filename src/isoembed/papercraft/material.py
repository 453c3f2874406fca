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
    """Material of a net and how it is cut, in millimeters.

    Parameters
    ----------
    joints : {"tabs", "stitches", "none"}
        How sides are joined: by tabs that get glue; by holes for stitches, as many on both sides, on the
        side itself where there is an allowance and `spacing` inside of it otherwise; or edge to edge.
    allowance : float
        Seam allowance of cloth or leather: the cut runs so far outside of the net, whose own outline is the
        seam.  Corners sharper than a right angle are cut off.  Not with tabs.
    spacing : float
        Of the holes for stitches.
    hole : float
        Their diameter.
    kerf : float
        Width of the beam or blade: what is cut out is offset outward by half of it, and holes inward.
    bends : {"score", "perforate"}
        How folds are cut: as a whole line, for a machine that scores; or as dashes that begin and end with
        material.
    dash, gap : float
        What is cut of a perforated fold, and what is left at least between two cuts.
    thickness : float
        Of board, foam or metal, which the faces leave room for where they meet; see
        `isoembed.papercraft.thickness.thickened`.
    surface : {"outside", "inside"}
        The surface of the thick sheet that has the faces of the solid.
    k_factor : float
        Where in the thickness a bend keeps its length, from 0, its inside, to 1.
    radius : float
        Of a bend, on its inside.
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
            known = get_args(kind)
            if getattr(self, name) not in known:
                raise InvalidParameter(f"{name} is {getattr(self, name)!r}, not one of {', '.join(known)}")
        positive = ("spacing", "hole", "dash", "gap")
        for name in (field.name for field in fields(self) if field.type is float):
            value = getattr(self, name)
            least = "above 0" if name in positive else "of at least 0"
            if not is_number(value) or not 0 <= value < math.inf or (name in positive and value == 0):
                said = f"{value:g}" if is_number(value) else repr(value)
                raise InvalidParameter(f"{name} is {said}, not a number {least}")
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
