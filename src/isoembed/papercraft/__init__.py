"""Printable and machine-cut paper nets of unfolded solids.

PDF needs matplotlib: ``pip install 'isoembed[plot]'``.
"""

from isoembed.papercraft.sheets import SHEET_ENDINGS, sheets_writer, write_sheets

__all__ = ["SHEET_ENDINGS", "sheets_writer", "write_sheets"]
