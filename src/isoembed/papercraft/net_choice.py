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
    size: float | tuple[str, float] | None = None,
    cut: Edges = (),
    keep: Edges = (),
) -> Unfolding:
    """Unfold a surface to a net that occupies few pages.

    Candidates are nets whose sheets fit on a portrait or a landscape page, and a net with short cuts that is
    divided into islands.  The result is the net for which `isoembed.papercraft.write_sheets` uses the fewest
    pages of the given paper at the given scale.

    Parameters
    ----------
    surface : Embedding
    paper, scale, size
        See `isoembed.papercraft.write_sheets`; a scale or a size is required.
    cut, keep
        See `isoembed.gluing.unfold`.

    Returns
    -------
    Unfolding

    Raises
    ------
    InvalidMetric
        See `isoembed.gluing.unfold`.
    InvalidParameter
        Scale and size are missing; or see `isoembed.gluing.unfold` and `isoembed.papercraft.write_sheets`.
    """
    if scale is None and size is None:
        raise InvalidParameter("the number of pages depends on the size of the solid: give a scale or a size")
    page = Paper.of(paper)
    short = unfold(surface, cut=cut, keep=keep, objective="length")
    layouts = {short: laid_out(short, paper, scale=scale, size=size)}
    for room in {tuple(one.room / layouts[short].scale): None for one in (page, page.turned)}:
        net = unfold(surface, cut=cut, keep=keep, within=room)
        layouts[net] = laid_out(net, paper, scale=scale, size=size)
    return min(layouts, key=lambda net: (layouts[net].pages, len(layouts[net].unfolding.sheets)))
