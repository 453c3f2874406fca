"""Paper nets: gluing of polygon sides to a polyhedral metric, and unfolding of solids.

`glue` is the main function and `Net` the main class; `unfold` is the inverse, from a solid to a net.  Zipped
polygons, pita forms, D-forms and the enumeration of edge-to-edge gluings build on them.
"""

from isoembed.gluing.enumeration import edge_gluings
from isoembed.gluing.forms import dform, pita, zipped
from isoembed.gluing.net import Net, glue
from isoembed.gluing.outlines import (
    Ellipse,
    Stadium,
    circle,
    from_sides,
    rectangle,
    regular_polygon,
    triangle,
)
from isoembed.gluing.solid import embed_net
from isoembed.gluing.unfolding import Unfolding, unfold

__all__ = [
    "Ellipse",
    "Net",
    "Stadium",
    "Unfolding",
    "circle",
    "dform",
    "edge_gluings",
    "embed_net",
    "from_sides",
    "glue",
    "pita",
    "rectangle",
    "regular_polygon",
    "triangle",
    "unfold",
    "zipped",
]
