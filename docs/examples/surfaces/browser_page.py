"""A page for the browser.

One file that needs no network: the surface to turn, its colors and the report. The picture is of the same
surface.
"""

from pathlib import Path

import isoembed
from isoembed.gallery import Drum, triangulate
from isoembed.plot import write_page, write_picture

surface = isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*triangulate(Drum(), 400)))
write_page("drum.html", surface, title="Drum")
page = Path("drum.html").read_text(encoding="utf-8")
assert "<title>Drum" in page and "https://" not in page
write_picture("browser_page.png", surface, color="Gaussian curvature")
