"""Printable and machine-cut paper nets of unfolded solids.

PDF needs matplotlib, ``pip install 'isoembed[plot]'``, and DXF ezdxf, ``pip install 'isoembed[dxf]'``.
"""

from isoembed.papercraft.folding import partly_folded
from isoembed.papercraft.material import Material
from isoembed.papercraft.net_choice import fewest_pages
from isoembed.papercraft.sheets import SHEET_ENDINGS, sheets_writer, write_sheets

__all__ = ["SHEET_ENDINGS", "Material", "fewest_pages", "partly_folded", "sheets_writer", "write_sheets"]
