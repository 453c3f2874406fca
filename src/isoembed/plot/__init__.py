"""Pictures of surfaces.  Needs matplotlib: ``pip install 'isoembed[plot]'``."""

from isoembed.plot.picture import PICTURE_ENDINGS, figure, picture_writer, write_picture

__all__ = ["PICTURE_ENDINGS", "figure", "picture_writer", "write_picture"]
