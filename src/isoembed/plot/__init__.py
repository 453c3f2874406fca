"""Pictures of surfaces: still ones, films, and pages for the browser; nets to cut out.

Still ones, films and nets as PDF need matplotlib: ``pip install 'isoembed[plot]'``.
"""

from isoembed.plot.animation import ANIMATION_ENDINGS, animation_writer, write_animation
from isoembed.plot.film import Film, Frame
from isoembed.plot.page import PAGE_ENDINGS, page_writer, write_page
from isoembed.plot.panel import Panel
from isoembed.plot.picture import (
    PICTURE_ENDINGS,
    figure,
    figure_writer,
    panels,
    picture_writer,
    write_picture,
)
from isoembed.plot.placed import Scale, placed_figure
from isoembed.plot.quantity import QUANTITIES, Quantity, quantities, quantity
from isoembed.plot.sheets import SHEET_ENDINGS, sheets_writer, write_sheets

__all__ = [
    "ANIMATION_ENDINGS",
    "PAGE_ENDINGS",
    "PICTURE_ENDINGS",
    "QUANTITIES",
    "SHEET_ENDINGS",
    "Film",
    "Frame",
    "Panel",
    "Quantity",
    "Scale",
    "animation_writer",
    "figure",
    "figure_writer",
    "page_writer",
    "panels",
    "picture_writer",
    "placed_figure",
    "quantities",
    "quantity",
    "sheets_writer",
    "write_animation",
    "write_page",
    "write_picture",
    "write_sheets",
]
