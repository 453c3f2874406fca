"""The endings of the files that pictures, pages and films go to."""

PICTURE_ENDINGS = (".png", ".svg", ".pdf")
PAGE_ENDINGS = (".html",)
ANIMATION_ENDINGS = (".gif", ".mp4")
SHEET_ENDINGS = (".svg", ".pdf")
