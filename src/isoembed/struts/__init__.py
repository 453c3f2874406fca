"""Strut tables of domes and frames: the edges of a surface as struts between hubs.

`strut_table` groups lengths into types, measures hubs, bends and dihedral angles, and packs the struts into
bars of stock length.
"""

from isoembed.struts.cut_list import Bar, CutList
from isoembed.struts.hubs import HubType
from isoembed.struts.saving import STRUT_ENDINGS
from isoembed.struts.table import FaceType, StrutTable, StrutType, strut_table

__all__ = [
    "STRUT_ENDINGS",
    "Bar",
    "CutList",
    "FaceType",
    "HubType",
    "StrutTable",
    "StrutType",
    "strut_table",
]
