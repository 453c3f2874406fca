"""Printable and machine-cut paper nets of unfolded solids.

PDF requires matplotlib, ``pip install matplotlib``, and DXF requires ezdxf, ``pip install ezdxf``.
"""

from isoembed.papercraft.curves import write_dform
from isoembed.papercraft.folding import partly_folded
from isoembed.papercraft.material import Material
from isoembed.papercraft.net_choice import fewest_pages
from isoembed.papercraft.saving import SHEET_ENDINGS, sheets_writer, write_sheets

__all__ = [
    "SHEET_ENDINGS",
    "Material",
    "fewest_pages",
    "partly_folded",
    "sheets_writer",
    "write_dform",
    "write_sheets",
]
