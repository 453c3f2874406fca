"""Convex polyhedra folded from a family of nets, in congruence classes."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, cast

from isoembed.alexandrov.method import Alexandrov
from isoembed.alexandrov.polyhedron import ConvexPolyhedron
from isoembed.alexandrov.solid import Solid
from isoembed.errors import NotEmbedded
from isoembed.gluing.net import Net
from isoembed.method import solve

HEADINGS = ("", "net", "solid", "vertices", "edges", "faces", "area", "volume")


@dataclass(frozen=True)
class Folded:
    """Solid folded from one net of a family.

    Attributes
    ----------
    number, kind : int
        Index of the net in the family, and of the solid's congruence class, from 1.
    label : str
        Label of the net.
    polyhedron : ConvexPolyhedron
    solid : Solid
    """

    number: int
    kind: int
    label: str
    polyhedron: ConvexPolyhedron
    solid: Solid


@dataclass(frozen=True)
class Folding:
    """Solids of a family of nets, and reasons for failures; as a string, a table.

    Attributes
    ----------
    folded : tuple of Folded
    failures : tuple of str
    """

    folded: tuple[Folded, ...]
    failures: tuple[str, ...]

    @property
    def report(self) -> dict[str, Any]:
        """Table for JSON: ``solids``, a list, and ``failures``, sentences."""
        solids = [
            {
                "net": one.number,
                "label": one.label,
                "kind": one.kind,
                "solid": one.solid.name,
                "vertices": one.solid.vertices,
                "edges": one.solid.edges,
                "faces": one.solid.faces,
                "area": one.polyhedron.area,
                "volume": one.polyhedron.volume,
            }
            for one in self.folded
        ]
        return {"solids": solids, "failures": list(self.failures)}

    def __str__(self) -> str:
        table: list[tuple[str, ...]] = [HEADINGS]
        for one in self.folded:
            counts = map(str, (one.solid.vertices, one.solid.edges, one.solid.faces))
            sizes = (f"{size:.9g}" for size in (one.polyhedron.area, one.polyhedron.volume))
            table.append((str(one.number), one.label, f"{one.kind}: {one.solid.name}", *counts, *sizes))
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        # Text is left-aligned, numbers are right-aligned.
        lines = [
            "  ".join(
                text.ljust(width) if 0 < k < 3 else text.rjust(width)
                for k, (text, width) in enumerate(zip(row, widths, strict=True))
            )
            for row in table
        ]
        kinds = {one.kind for one in self.folded}
        counted = f"{len(self.folded) + len(self.failures)} nets, {len(kinds)} solids"
        return "\n".join([*lines, "", counted])


def fold(nets: Iterable[tuple[str, Net]]) -> Folding:
    """Embed nets, and classify their solids by congruence.

    Parameters
    ----------
    nets : iterable of (str, Net)
        Labeled nets, such as ``CLASSICS["latin-cross"].make()``.

    Returns
    -------
    Folding
    """
    folded: list[Folded] = []
    kinds: list[Solid] = []
    failures: list[str] = []
    for number, (label, net) in enumerate(nets, 1):
        try:
            polyhedron = cast(ConvexPolyhedron, solve(net, Alexandrov()))
        except NotEmbedded as error:
            failures.append(f"net {number}, {label}: {error}")
            continue
        solid = Solid.of(polyhedron)
        kind = next((k for k, other in enumerate(kinds) if solid.is_congruent(other)), len(kinds))
        kinds += [solid] if kind == len(kinds) else []
        folded.append(Folded(number, kind + 1, label, polyhedron, solid))
    return Folding(tuple(folded), tuple(failures))
