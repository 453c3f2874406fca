"""File name endings of pictures, pages and films."""

PICTURE_ENDINGS = (".png", ".svg", ".pdf")
PAGE_ENDINGS = (".html",)
ANIMATION_ENDINGS = (".gif", ".mp4")
