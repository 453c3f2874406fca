"""Nets from vector drawings: sheets, folds, and sides matched by numbers, colors, angles or lengths."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace

import numpy as np

from isoembed.arrays import Floats
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote, warn_of_mesh
from isoembed.gluing import Net, dform, edge_gluings, glue
from isoembed.gluing.creases import fold_up, meeting_corners, meeting_tolerance
from isoembed.gluing.dashes import undashed
from isoembed.gluing.drawn_lines import CUT, FOLD, GLUE, READ, SEAM, Line, Lines, Number
from isoembed.gluing.line_graph import LineGraph, Side, is_inside
from isoembed.gluing.offset import offset
from isoembed.gluing.polygon import side_lengths
from isoembed.io.crease_pattern import with_places
from isoembed.io.files import FileError
from isoembed.reprs import rounded_up

SNAP = 1e-6  # of the size of the drawing: distance at which ends are joined if not all coincide
UNITS = 4.0  # of the last digit: possible difference of rounded points and of lengths between them
MOST_SAID = 3  # numbers listed in a message

Pair = tuple[Side, Side]


def drawn_net(drawing: Lines, name: str, tolerance: float | None = None) -> Net:
    """Glue a drawn net.

    Outlines are cut, and lines between faces are folded.  Tabs, marked by glue areas, are discarded.  Sides
    are paired by equal numbers; then by a color that exactly two sides share; by coincidence after folding
    with the given angles; by a length that exactly two sides share; and finally by the unique convex gluing.
    If the drawing allows a boundary, sides without a number are boundary sides.  Two closed curves are glued
    into a D-form, starting at their first points.

    Parameters
    ----------
    drawing : Lines
    name : str
        File name, for messages.
    tolerance : float, optional
        Largest difference of glued lengths, mm; by default four units of the last digit, or the rounding
        error of the points if the file states it.

    Raises
    ------
    FileError
        The drawing has no outlines.
    InvalidMetric, InvalidParameter
        The lines make no sheets, a side has no mate, or `isoembed.glue` fails.
    """
    try:
        return _drawn_net(drawing, name, tolerance)
    except (InvalidMetric, InvalidParameter) as error:
        if remedy := _joining(drawing, name, tolerance):
            raise type(error)(f"{error}; {remedy}") from None
        raise


def _joining(drawing: Lines, name: str, tolerance: float | None) -> str:
    """End of an error message: the smallest gap between lines, if a tolerance that closes it helps."""
    lines = [line.points for line in drawing.lines if line.purpose in ("", CUT, FOLD)]
    if not lines or sum(map(len, lines)) > 2000:  # too many pairs
        return ""
    ends = np.concatenate([np.stack([points[:-1], points[1:]], axis=1) for points in lines])
    points = np.unique(ends.reshape(-1, 2), axis=0)
    step = ends[:, 1] - ends[:, 0]
    away = points[:, None] - ends[:, 0]
    part = np.clip((away * step).sum(axis=2) / np.maximum((step * step).sum(axis=1), 1e-300), 0.0, 1.0)
    apart = np.hypot(*np.moveaxis(away - part[..., None] * step, 2, 0))
    size = float(np.ptp(points, axis=0).max())
    apart[apart <= max(SNAP * size, tolerance or 0.0)] = np.inf
    p = int(np.argmin(nearest := apart.min(axis=1)))
    gap, (x, y) = float(nearest[p]), points[p].tolist()
    # Lines up to 1 % of the drawing apart may be meant to meet; lengths between points have twice the gap.
    for share in (1.1, 2.2) if gap <= 0.01 * size else ():
        word = f"{float(rounded_up(share * gap)):g}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshNote)
            try:
                _drawn_net(drawing, name, float(word))
            except (InvalidMetric, InvalidParameter):
                continue
        return f"a line ends at [{x:.6g}, {y:.6g}], {gap:.2g} mm from another: tolerance={word} joins them"
    return ""


def _drawn_net(drawing: Lines, name: str, tolerance: float | None) -> Net:
    """Implementation of `drawn_net`, without the remedies in error messages."""
    lines = [line for line in drawing.lines if line.purpose != READ]
    glued = [line.points[:-1] for line in lines if line.purpose == GLUE and line.is_closed]
    lines = [line for line in lines if line.purpose != GLUE]
    seams = [replace(line, purpose=CUT) for line in lines if line.purpose == SEAM]
    if seams:  # the cut outline is wider, by the seam allowance
        lines = seams + [line for line in lines if line.purpose not in (CUT, SEAM)]
    if not lines:
        raise FileError(f"{name} has no lines to cut")
    every = np.concatenate([line.points for line in lines])
    size = float(np.ptp(every, axis=0).max())
    near = max(SNAP * size, 2 * drawing.unit, tolerance or 0.0)
    curves = [line.points[:-1] for line in lines if line.is_closed and line.is_curve]
    if len(curves) == len(lines) == 2:
        return _dform(curves[0], curves[1], tolerance)
    lines = undashed(_without_kerf(_without_holes(lines), 0.0 if seams else drawing.kerf), near)
    if not any(line.purpose == FOLD for line in lines):  # layers do not distinguish cuts from folds
        lines = [replace(line, purpose="") for line in lines]
    graph = _graph(lines, max(UNITS * drawing.unit, tolerance or 0.0), near)
    if not graph.faces:
        raise FileError(f"{name} has no closed outlines: its lines enclose nothing")
    quiet = tolerance is None
    if tolerance is None and (drawing.unit > 0 or drawing.error > 0):
        tolerance = max(UNITS * drawing.unit, 2 * drawing.error)
    any_surface = drawing.any_surface
    sheets = graph.without(_tabs(graph, glued, () if any_surface else drawing.numbers))
    folded = _folded(sheets, near)
    allowed = near if tolerance is None else max(tolerance, near)
    pairs, by_length = _mates(sheets, drawing, folded, allowed)
    pairs += [(side, twin) for side, twin in sheets.twins.items() if side < twin]
    with warnings.catch_warnings():
        if quiet:  # differences of sides are explained by the digits; the correction is reported below
            warnings.simplefilter("ignore", MeshNote)
        polygons = [sheets.points[face] for face in sheets.faces]
        try:
            net = glue(polygons, pairs, tolerance=tolerance, any_surface=any_surface)
        except InvalidMetric as error:
            if not by_length:
                raise
            raise InvalidMetric(
                f"{error}; sides without a number were glued by their lengths, which does not always tell "
                "them apart: write the same number at the two sides that are glued, "
                "or if their lengths differ, draw with more digits"
            ) from None
    if quiet and net.correction and net.correction.largest > max(SNAP * size, 2 * drawing.error):
        warn_of_mesh(str(replace(net.correction, source=f"{tolerance:.2g}, by the digits of the drawing")))
    return with_places(net, sheets.faces, folded)


def _graph(lines: Sequence[Line], tolerance: float, near: float) -> LineGraph:
    """Graph of lines whose ends coincide to the digits, or else nearly coincide."""
    if tolerance < near:
        try:
            graph = LineGraph.of(lines, tolerance)
        except InvalidMetric:
            return LineGraph.of(lines, near)
        if not graph.loose:
            return graph
    return LineGraph.of(lines, near)


def _dform(first: Floats, second: Floats, tolerance: float | None) -> Net:
    """D-form of two curved outlines, glued from their first points on."""
    around = [float(side_lengths(points).sum()) for points in (first, second)]
    allowed = 1e-3 * around[0] if tolerance is None else tolerance  # the curves are sampled
    if abs(around[1] - around[0]) > allowed:
        raise InvalidMetric(
            f"two curves that are glued all around are {around[0]:.6g} and {around[1]:.6g} mm long, which "
            f"differ by more than the tolerance {allowed:.2g}"
        )
    return dform(first, second)


def _without_holes(lines: Sequence[Line]) -> list[Line]:
    """Lines without circles inside others, which are stitching holes."""
    around = [line.points[:-1] for line in lines if line.is_closed and not line.is_circle]
    return [
        line
        for line in lines
        if not line.is_circle or not any(is_inside(line.points[0], corners) for corners in around)
    ]


def _without_kerf(lines: Sequence[Line], kerf: float) -> list[Line]:
    """Outlines of the material left after cutting with a beam of the given width."""
    if not kerf:
        return list(lines)
    found = []
    for k, line in enumerate(lines):
        if line.purpose == CUT and line.is_closed:
            corners = offset(line.points[:-1], -kerf / 2, f"outline {k}")
            line = replace(line, points=np.concatenate([corners, corners[:1]]))
        found.append(line)
    return found


def _tabs(graph: LineGraph, glued: Sequence[Floats], numbers: Sequence[Number]) -> set[int]:
    """Faces that are tabs: those with glue areas or, if none are drawn, end faces without a number."""
    ends = [f for f in range(len(graph.faces)) if len(graph.folds(f)) == 1]
    marks = [area.mean(axis=0) for area in glued] or [np.array([one.x, one.y]) for one in numbers]
    if not marks:
        return set()
    marked = {f for f in ends if any(is_inside(mark, graph.points[graph.faces[f]]) for mark in marks)}
    return marked if glued else set(ends) - marked


def _folded(sheets: LineGraph, near: float) -> tuple[Floats, np.ndarray] | None:
    """Faces folded by the angles of the lines between them; None if angles are missing."""
    angles = {}
    for side in sheets.twins:
        angle = sheets.lines[side].angle
        if angle is None:
            return None
        a, b = sorted(_corners(sheets, side))
        angles[a, b] = -float(np.radians(angle))
    if len(angles) != _shared(sheets):  # a slit
        return None
    return fold_up(sheets.points, sheets.faces, angles, max(near, meeting_tolerance(sheets.points)))


def _shared(sheets: LineGraph) -> int:
    """Number of edges with a face on both sides."""
    sides = [(f, k) for f, face in enumerate(sheets.faces) for k in range(len(face))]
    return len(sides) - len({tuple(sorted(_corners(sheets, side))) for side in sides})


def _mates(
    sheets: LineGraph, drawing: Lines, folded: tuple[Floats, np.ndarray] | None, tolerance: float
) -> tuple[list[Pair], bool]:
    """Pairs of glued sides, and whether some were matched by length."""
    left = [
        (f, k) for f, face in enumerate(sheets.faces) for k in range(len(face)) if (f, k) not in sheets.twins
    ]
    pairs: list[Pair] = []

    def match(key: Callable[[Side], Hashable | None]) -> None:
        """Pair the sides whose key is shared by exactly two."""
        nonlocal left
        by_key: dict[Hashable, list[Side]] = {}
        for side in left:
            if (value := key(side)) is not None:
                by_key.setdefault(value, []).append(side)
        found = [(some[0], some[1]) for some in by_key.values() if len(some) == 2]
        pairs.extend(found)
        matched = {side for pair in found for side in pair}
        left = [side for side in left if side not in matched]

    numbered = _numbered(sheets, drawing.numbers, left, tolerance)
    _check_twice(numbered)
    match(numbered.get)
    if drawing.any_surface:
        return pairs, False
    colors = {sheets.lines[side].color for side in left}
    if len(colors) > 1:
        match(lambda side: sheets.lines[side].color or None)
    if left and folded is not None and not folded[1].any():
        names = meeting_corners(*folded[:1], sheets.faces, folded[1], tolerance)
        match(lambda side: tuple(sorted(names[v] for v in _corners(sheets, side))))
    by_length = bool(left)
    if left:
        before = len(left)
        match(_by_length(sheets, left, tolerance).get)
        if numbered and len(left) < before:
            warn_of_mesh(f"{before - len(left)} sides that no number pairs are glued by their lengths")
    if left:
        pairs += _searched(sheets, pairs, left, tolerance)
    return pairs, by_length


def _corners(sheets: LineGraph, side: Side) -> tuple[int, int]:
    f, k = side
    return sheets.faces[f][k], sheets.faces[f][(k + 1) % len(sheets.faces[f])]


def _length(sheets: LineGraph, side: Side) -> float:
    return float(np.hypot(*np.diff(sheets.ends(side), axis=0)[0]))


def _numbered(
    sheets: LineGraph, numbers: Sequence[Number], sides: Sequence[Side], tolerance: float
) -> dict[Side, str]:
    """Number at each side; numbers are assigned to nearby sides."""
    from scipy.optimize import linear_sum_assignment  # slow to import

    written = [one for one in numbers if one.text.strip()]
    if not written or not sides:
        return {}
    ends = np.array([sheets.ends(side) for side in sides])
    step = ends[:, 1] - ends[:, 0]
    length = np.hypot(*step.T)
    places = np.array([[one.x, one.y] for one in written])
    away = places[:, None] - ends[:, 0]
    part = np.clip((away * step).sum(axis=2) / length**2, 0.0, 1.0)
    apart = np.hypot(*np.moveaxis(away - part[..., None] * step, 2, 0))
    inward = step[:, 0] * away[..., 1] - step[:, 1] * away[..., 0] > 0
    heights = np.array([one.height for one in written])
    close = (apart <= 3.0 * heights[:, None]).any(axis=1)  # others belong to no side
    cost = np.where(inward, apart, 2 * apart + heights[:, None])
    angles = np.radians([one.angle for one in written])
    if angles.any():  # numbers are written along their sides
        turned = np.abs(np.sin(angles[:, None] - np.arctan2(step[:, 1], step[:, 0])))
        cost += 30.0 * heights[:, None] * turned
    cost = cost[close]
    rows, columns = linear_sum_assignment(cost)
    texts = [one.text.strip() for one, near in zip(written, close, strict=True) if near]
    found = {sides[c]: texts[r] for r, c in zip(rows.tolist(), columns.tolist(), strict=True)}
    by_text: dict[str, list[Side]] = {}
    for side, text in found.items():
        by_text.setdefault(text, []).append(side)
    paired = {text: some for text, some in by_text.items() if len(some) == 2}
    lengths = {text: [_length(sheets, side) for side in some] for text, some in paired.items()}
    differences = {text: abs(one - other) for text, (one, other) in lengths.items()}
    for text, some in paired.items():
        if differences[text] > 2 * tolerance:
            raise InvalidMetric(
                f"the sides with the number {text} are {lengths[text][0]:.6g} and {lengths[text][1]:.6g} mm "
                f"long, {_where(sheets, some[0])} and {_where(sheets, some[1])}: give a tolerance of "
                f"{float(rounded_up(max(differences.values()))):g}, or correct them"
            )
    return found


def _check_twice(numbered: dict[Side, str]) -> None:
    """Warn of unmatched numbers, if others match."""
    counts = Counter(numbered.values())
    odd = [
        f"{text} at {count} side{'' if count == 1 else 's'}" for text, count in counts.items() if count != 2
    ]
    if odd and len(odd) < len(counts):
        more = f", and {len(odd) - MOST_SAID} more" if len(odd) > MOST_SAID else ""
        warn_of_mesh(f"numbers that are not at two sides glue none: {', '.join(odd[:MOST_SAID])}{more}")


def _by_length(sheets: LineGraph, sides: Sequence[Side], tolerance: float) -> dict[Side, int]:
    """Length class of each side."""
    lengths = np.array([_length(sheets, side) for side in sides])
    order = np.argsort(lengths, kind="stable")
    classes = np.cumsum(np.diff(lengths[order], prepend=lengths[order[0]]) > tolerance)
    return {sides[k]: int(c) for k, c in zip(order.tolist(), classes, strict=True)}


def _searched(sheets: LineGraph, pairs: Sequence[Pair], left: Sequence[Side], tolerance: float) -> list[Pair]:
    """Pairs of the unique convex gluing of one sheet that extends the given pairs."""
    outline = _outline(sheets)
    if outline is None or len(outline) > 40:  # too many to enumerate
        raise _no_mate(sheets, left, tolerance)
    number = {side: k for k, side in enumerate(outline)}
    numbered = {tuple(sorted((number[one], number[other]))) for one, other in pairs}
    points = np.array([sheets.ends(side)[0] for side in outline])
    found = [
        some
        for some in (
            [(i, k) for (_, i), (_, k) in sides] for sides in edge_gluings(points, tolerance=tolerance)
        )
        if numbered <= set(some)
    ]
    if len(found) != 1:
        raise _no_mate(sheets, left, tolerance, len(found))
    return [(outline[i], outline[k]) for i, k in found[0] if (i, k) not in numbered]


def _outline(sheets: LineGraph) -> list[Side] | None:
    """Sides around a single sheet, counterclockwise; None if there are several sheets."""
    around: list[Side] = []
    side = first = next(
        (f, k) for f, face in enumerate(sheets.faces) for k in range(len(face)) if (f, k) not in sheets.twins
    )
    while not around or side != first:
        around.append(side)
        f, k = side
        side = f, (k + 1) % len(sheets.faces[f])
        while side in sheets.twins:
            f, k = sheets.twins[side]
            side = f, (k + 1) % len(sheets.faces[f])
    count = sum(map(len, sheets.faces)) - len(sheets.twins)
    return around if len(around) == count else None


def _no_mate(sheets: LineGraph, left: Sequence[Side], tolerance: float, ways: int = 0) -> InvalidParameter:
    several = f": {ways} ways to glue it make a convex solid" if ways else ""
    length = _length(sheets, left[0])
    digits = (
        ", or if their lengths differ, draw with more digits: lengths that differ by less than "
        f"{tolerance:.2g} mm are not distinguished"
        if tolerance > 1e-3 * length
        else ""
    )
    return InvalidParameter(
        f"the side {_where(sheets, left[0])}, {length:.6g} mm long, has no mate that is "
        f"certain{several}; write the same number at the two sides that are glued{digits}"
    )


def _where(sheets: LineGraph, side: Side) -> str:
    (x, y), (u, v) = sheets.ends(side).tolist()
    return f"from [{x:.6g}, {y:.6g}] to [{u:.6g}, {v:.6g}]"
