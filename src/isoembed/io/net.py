"""Paper nets in files: polygons with identified sides or named forms in JSON, FOLD files, and drawings."""

import os
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from isoembed.errors import InvalidParameter
from isoembed.gluing import (
    Ellipse,
    Net,
    Stadium,
    circle,
    dform,
    glue,
    pita,
    rectangle,
    regular_polygon,
    triangle,
    zipped,
)
from isoembed.gluing.unfolding import Unfolding
from isoembed.io import json
from isoembed.io.crease_pattern import (
    crease_pattern,
    creased_net,
    creases,
    declared_any_surface,
    read_crease_pattern,
    solid_entries,
)
from isoembed.io.drawn_net import drawn_net
from isoembed.io.dxf_lines import read_dxf_lines
from isoembed.io.files import FileError, Writer, check_ending, ending, input_ending, write_atomically
from isoembed.io.fold import CORNERS
from isoembed.io.input_file import InputFile
from isoembed.io.registry import FORMATS, check_output
from isoembed.io.svg_lines import read_svg_lines
from isoembed.space import Space
from isoembed.space.models import MODELS, Model, to_model
from isoembed.strict_json import strict_json

Makers = dict[str, tuple[Callable[..., Any], int, int]]
"""Shapes by name: constructor, and smallest and largest number of arguments."""

NET_ENDINGS = (".json", ".fold")
DRAWN = {".svg": read_svg_lines, ".dxf": read_dxf_lines}
"""Readers of the lines of a drawn net, by file ending."""
FORMS = ("polygons", "regular", "zip", "pita", "dform")
CURVED: Makers = {"triangle": (triangle, 3, 3), "regular": (regular_polygon, 1, 2)}
"""Polygons in the Euclidean plane, the hyperbolic plane and the sphere."""
POLYGONS: Makers = {"rectangle": (rectangle, 2, 2), **CURVED}
CURVES: Makers = {"circle": (circle, 1, 1), "ellipse": (Ellipse, 2, 2), "stadium": (Stadium, 2, 2)}
OUTLINES = POLYGONS | CURVES


def read_net(source: str | os.PathLike[str], *, tolerance: float | None = None) -> Net:
    """Read a net and glue it.

    Parameters
    ----------
    source : path or "-"
        A ``.json`` file, or ``-`` for standard input: an object with ``polygons`` and ``sides`` or
        ``corners``, as in `isoembed.glue`; with ``sides`` optionally ``folds``, for each polygon a list of
        ``[corner, corner, degrees]``, positive where the solid is convex; or with one of

        - ``"regular": [names, ...]``: the names of the corners of regular polygons with sides of length 1
        - ``"zip": {"polygon": POLYGON, "at": position}``
        - ``"pita": {"outline": OUTLINE, "at": part, "n": sides}``
        - ``"dform": {"outlines": [OUTLINE, OUTLINE], "offset": part, "n": sides}``

        A POLYGON is a list of corners ``[x, y]``, or ``{"rectangle": [width, height]}``,
        ``{"triangle": [a, b, c]}`` by its sides, ``{"regular": n}`` or ``{"regular": [n, side]}``.  An
        OUTLINE is a polygon, or ``{"circle": radius}``, ``{"ellipse": [a, b]}``,
        ``{"stadium": [length, radius]}``.  ``at``, ``offset`` and ``n`` of pita and D-forms may be left out.

        ``polygons``, ``regular`` or ``zip`` may be accompanied by the ``"curvature"`` of the hyperbolic plane
        or sphere from which the polygons are cut, and the ``"model"`` of the corner coordinates, as in
        `isoembed.glue`; ``polygons`` and ``regular`` also by ``"any_surface": true`` if unglued sides are a
        boundary.

        Or a ``.fold`` file: a crease pattern with vertex names in ``vertices_isoembed:corner``, like the
        corners of `isoembed.glue`.

        Or a drawing, ``.svg`` or ``.dxf``: outlines to cut, folds, and equal numbers at glued sides, as drawn
        by `isoembed.papercraft.write_sheets` or other programs; see `isoembed.io.drawn_net.drawn_net`.  The
        unit of the net is the millimeter.
    tolerance : float, optional
        Tolerance of `isoembed.glue`, for polygons, crease patterns and drawings.  A crease pattern without
        names is folded, and corners within this distance are identified; by default 1e-4 of the sheet size.

    Raises
    ------
    FileError
        The file cannot be read, or does not have this form.
    InvalidMetric, InvalidParameter
        The contents make no metric.
    """
    if source == "-":
        return _net(json.read_standard_input(), "standard input", tolerance)
    if input_ending(source) in FORMATS.keys() - set(NET_ENDINGS):
        raise FileError(
            f"{source} is not a net ({' '.join((*NET_ENDINGS, *DRAWN))}): a metric or a mesh is embedded, "
            f"with isoembed.embed({str(source)!r})"
        )
    check_ending(source, (*NET_ENDINGS, *DRAWN))
    with InputFile(source) as file:
        if file.ending in DRAWN:
            return drawn_net(DRAWN[file.ending](file), str(source), tolerance)
        if file.ending == ".fold":
            return read_crease_pattern(file, tolerance)
        return _net(json.read(file), str(source), tolerance)


def holds_net(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a net, by its entry names or as a drawing: input for `read_net`, not a surface.

    Raises
    ------
    FileError
        A file that may be a net cannot be opened, or is not text.
    """
    if input_ending(path) in DRAWN:
        return True
    if input_ending(path) not in NET_ENDINGS:
        return False
    with InputFile(path) as file:
        if file.ending == ".json":
            return re.search(rf'"({"|".join(FORMS)})"\s*:', file.text) is not None
        return "foldedForm" not in file.text and re.search(f"{CORNERS}|creasePattern", file.text) is not None


def net_writer(path: str | os.PathLike[str], unfolding: Unfolding) -> Writer:
    """Writer of a net in the format of the path's ending; see `write_atomically` and `write_net`."""
    unfolding.net  # noqa: B018, who reads it will glue it
    is_fold = ending(path) == ".fold"
    sheets = {"polygons": unfolding.sheets, "sides": unfolding.sides, "folds": creases(unfolding)}
    sheets |= solid_entries(unfolding, "precision", "any_surface")
    text = strict_json(crease_pattern(unfolding) if is_fold else sheets) + "\n"
    return lambda temporary: temporary.write_text(text, encoding="utf-8")


def write_net(path: str | os.PathLike[str], unfolding: Unfolding) -> None:
    """Write the sheets of a solid in a form that `read_net` can glue.

    Parameters
    ----------
    path : path
        Ends with ``.json``, or with ``.fold`` for a crease pattern with fold angles.
    unfolding : Unfolding

    Raises
    ------
    FileError
        The ending is unknown or the file cannot be written.
    InvalidMetric
        Faces or sides of the surface are so thin or small that the sheets cannot be glued in floating point.
    """
    check_output(path, NET_ENDINGS)
    write_atomically({Path(path): net_writer(path, unfolding)})


def _net(document: Mapping[str, Any], name: str, tolerance: float | None) -> Net:
    forms = [key for key in FORMS if key in document]
    if len(forms) != 1:
        there = " and ".join(forms) if forms else ", ".join(document) or "nothing"
        raise FileError(
            f"{name} holds {there}: a net is polygons with sides or corners, "
            "or one of regular, zip, pita and dform"
        )
    form = forms[0]
    surface = _surface(document, name) if form in ("polygons", "regular", "zip") else {}
    if form == "polygons":
        how = "corners" if "corners" in document else "sides"
        optional = (*surface, "any_surface", "folds", "precision")
        entries = _entries(document, name, ("polygons", how), optional)
        polygons = _list(entries["polygons"], f"polygons of {name}")
        if "folds" in entries:
            if how != "sides" or surface:
                raise FileError(f"{name} has folds, which are for sides that are glued, in the plane")
            return creased_net(entries, tolerance, name)
        shapes = [_polygon(polygon, f"polygon {p}", **surface) for p, polygon in enumerate(polygons)]
        glued = _list(entries[how], f"{how} of {name}")
        options: dict[str, Any] = {how: glued, **surface, "any_surface": declared_any_surface(entries, name)}
        return glue(shapes, tolerance=tolerance, **options)
    if tolerance is not None:
        raise InvalidParameter(f"{name} holds {form}, which is exact: a tolerance is for polygons")
    _entries(document, name, (form,), (*surface, "any_surface") if form == "regular" else tuple(surface))
    if form == "regular":
        faces = _list(document["regular"], f"regular polygons of {name}")
        sizes = [
            len(face if isinstance(face, str) else _list(face, f"corners of polygon {p}"))
            for p, face in enumerate(faces)
        ]
        curvature = surface.get("curvature", 0.0)
        shapes = [regular_polygon(n, curvature=curvature) for n in sizes]
        any_surface = declared_any_surface(document, name)
        return glue(shapes, corners=faces, curvature=curvature, any_surface=any_surface)
    if form == "zip":
        entries = _entries(document["zip"], f"zip of {name}", ("polygon", "at"))
        return zipped(_polygon(entries["polygon"], "the polygon", **surface), entries["at"], **surface)
    if form == "pita":
        entries = _entries(document["pita"], f"pita of {name}", ("outline",), ("at", "n"))
        return pita(_shape(entries.pop("outline"), "the outline", OUTLINES), **entries)
    entries = _entries(document["dform"], f"dform of {name}", ("outlines",), ("offset", "n"))
    outlines = _list(entries.pop("outlines"), f"outlines of {name}")
    if len(outlines) != 2:
        raise FileError(f"the outlines of {name} are {len(outlines)}, not 2")
    first, second = (_shape(outline, f"outline {k}", OUTLINES) for k, outline in enumerate(outlines))
    return dform(first, second, **entries)


def _entries(
    entry: Any, name: str, needed: tuple[str, ...], optional: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Entries of a JSON object, checked for missing and unknown names."""
    if not isinstance(entry, Mapping):
        raise FileError(f"{name} is not an object with {', '.join(needed)}")
    for key in needed:
        if key not in entry:
            raise FileError(f"{name} lacks {key!r}")
    for key in entry:
        if key not in needed + optional:
            raise FileError(f"{name} has {key!r}, which is none of {', '.join(needed + optional)}")
    return dict(entry)


def _surface(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """``curvature`` and ``model`` of a net, if given."""
    options = {key: document[key] for key in ("curvature", "model") if key in document}
    if "curvature" in options:
        try:
            Space(options["curvature"])
        except InvalidParameter as error:
            raise FileError(f"{name}: {error}") from None
    if "model" in options and options["model"] not in MODELS:
        raise FileError(f"{name}: the model is {options['model']!r}, none of {', '.join(MODELS)}")
    return options


def _polygon(entry: Any, name: str, curvature: float = 0.0, model: Model = "ambient") -> Any:
    """Polygon in a model: as given, or constructed by name."""
    if not isinstance(entry, dict) or curvature == 0:
        return _shape(entry, name, POLYGONS)
    bent: Makers = {
        shape: (partial(make, curvature=curvature), fewest, maximum)
        for shape, (make, fewest, maximum) in CURVED.items()
    }
    return to_model(Space(curvature), _shape(entry, name, bent), model)


def _list(entry: Any, name: str) -> list[Any]:
    if not isinstance(entry, list):
        raise FileError(f"the {name} are not a list")
    return entry


def _shape(entry: Any, name: str, makers: Makers) -> Any:
    """Shape as given or, for ``{"name": numbers}``, constructed by name."""
    if not isinstance(entry, dict):
        return entry
    if len(entry) != 1 or next(iter(entry)) not in makers:
        raise FileError(f"{name} is {', '.join(entry) or 'nothing'}, not one of {', '.join(makers)}")
    ((shape, numbers),) = entry.items()
    make, fewest, maximum = makers[shape]
    values = numbers if isinstance(numbers, list) else [numbers]
    if not fewest <= len(values) <= maximum:
        count = fewest if fewest == maximum else f"{fewest} or {maximum}"
        raise FileError(f"{name} is a {shape} of {len(values)} numbers, not {count}")
    return make(*values)
