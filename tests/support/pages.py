"""The pages of the documentation, and how far apart two pictures are."""

import re

import numpy as np
from PIL import Image

from places import ROOT

DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("**/*.md"))]
PICTURE = re.compile(r"!\[[^\]]*\]\((images/gallery/[^)]+)\)")


def coarse(picture):
    """The picture in cells of about 16 x 16 pixels, so that neither fonts nor edges of triangles count."""
    rows, columns = (max(size // 16, 1) for size in picture.size[::-1])
    return np.asarray(picture.convert("RGB").resize((columns, rows), Image.Resampling.BOX), dtype=float)


def difference(one, two):
    """The mean difference of two pictures, over 255; 1 if their sizes differ by more than two percent."""
    if any(abs(a / b - 1) > 0.02 for a, b in zip(one.size, two.size, strict=True)):
        return 1.0
    return float(np.abs(coarse(one) - coarse(two.resize(one.size))).mean() / 255)


ALIKE = 0.01  # a picture and itself in 256 colors differ by less than half of that
