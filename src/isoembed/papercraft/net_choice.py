"""Search for the net with the fewest pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from isoembed.errors import InvalidParameter
from isoembed.gluing.unfolding import Unfolding, unfold
from isoembed.papercraft.paper import Paper
from isoembed.papercraft.placing import laid_out

if TYPE_CHECKING:
    from isoembed.embedding.embedding import Embedding
    from isoembed.gluing.edge_choice import Edges


def fewest_pages(
    surface: Embedding,
    *,
    paper: str = "A4",
    scale: float | None = None,
    size: float | None = None,
    cut: Edges = (),
    keep: Edges = (),
) -> Unfolding:
    """Unfold a surface so that its net takes few pages: its sheets fit on a page each.

    Nets are searched for whose sheets fit on an upright page, and on one that is turned; and one with short
    cuts is cut into islands.  The one is returned that `isoembed.papercraft.write_sheets` puts on the fewest
    pages of this paper at this scale.

    Parameters
    ----------
    surface : Embedding
    paper, scale, size
        As of `isoembed.papercraft.write_sheets`; a scale or a size is needed.
    cut, keep
        As of `isoembed.gluing.unfold`.

    Returns
    -------
    Unfolding

    Raises
    ------
    InvalidMetric
        As `isoembed.gluing.unfold`.
    InvalidParameter
        There is no scale or size, and as `isoembed.gluing.unfold` and `isoembed.papercraft.write_sheets`.
    """
    if scale is None and size is None:
        raise InvalidParameter("the fewest pages depend on how large the solid is: give a scale or a size")
    page = Paper.of(paper)
    short = unfold(surface, cut=cut, keep=keep, objective="length")
    layouts = {short: laid_out(short, paper, scale=scale, size=size)}
    for room in {tuple(one.room / layouts[short].scale): None for one in (page, page.turned)}:
        net = unfold(surface, cut=cut, keep=keep, within=room)
        layouts[net] = laid_out(net, paper, scale=scale, size=size)
    return min(layouts, key=lambda net: (layouts[net].pages, len(layouts[net].unfolding.sheets)))
