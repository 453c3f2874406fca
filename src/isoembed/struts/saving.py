"""Strut tables as text, CSV and JSON."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.io.files import Writer, ending, write_atomically
from isoembed.io.registry import check_output
from isoembed.io.report import report_writer

if TYPE_CHECKING:
    from isoembed.struts.table import StrutTable

STRUT_ENDINGS = (".csv", ".json")
LENGTH, ANGLE = "{:.12g}", "{:.6g}"


def save(table: StrutTable, path: str | os.PathLike[str]) -> None:
    """See `StrutTable.save`."""
    check_output(path, STRUT_ENDINGS)
    write_atomically({Path(path): struts_writer(path, table)})


def struts_writer(path: str | os.PathLike[str], table: StrutTable) -> Writer:
    """Writer of a strut table in the format of the path's ending; see `write_atomically`."""
    if ending(path) == ".json":
        return report_writer(report(table))
    return lambda temporary: temporary.write_text(csv_text(table), encoding="utf-8", newline="")


def report(table: StrutTable) -> dict[str, Any]:
    """See `StrutTable.report`."""
    return {
        "tolerance": table.tolerance,
        "radius": table.radius,
        "hub_radius": table.hub_radius,
        "strut_types": [asdict(one) for one in table.struts],
        "hub_types": [{**asdict(one), "strut_angles": one.strut_angles} for one in table.hubs],
        "face_types": [asdict(one) for one in table.faces],
        "cuts": None if table.cuts is None else {**asdict(table.cuts), "waste": table.cuts.waste},
        "struts": [
            {"from": a, "to": b, "type": table.struts[k].name, "length": length, "dihedral": dihedral}
            for (a, b), k, length, dihedral in zip(
                table.edges.tolist(),
                table.types.tolist(),
                table.lengths.tolist(),
                table.dihedral_angles.tolist(),
                strict=True,
            )
        ],
        "hubs": [None if k < 0 else table.hubs[k].name for k in table.hub_types.tolist()],
    }


def csv_text(table: StrutTable) -> str:
    """See `StrutTable.to_csv`."""
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["type", "count", "length", "cut length", "spread", "chord factor", "central angle"])
    for one in table.struts:
        numbers = [LENGTH.format(value) for value in (one.length, one.cut_length)] + [f"{one.spread:.3g}"]
        if one.chord_factor is not None and one.central_angle is not None:
            numbers += [LENGTH.format(one.chord_factor), ANGLE.format(one.central_angle)]
        writer.writerow([one.name, one.count, *numbers])
    writer.writerow([])
    writer.writerow(["hub", "count", "struts", "angles", "bends", "strut angles", "boundary"])
    for hub in table.hubs:
        angles = (" ".join(map(ANGLE.format, some)) for some in (hub.angles, hub.bends, hub.strut_angles))
        on = "yes" if hub.is_on_boundary else "no"
        writer.writerow([hub.name, hub.count, "-".join(hub.struts), *angles, on])
    writer.writerow([])
    writer.writerow(["face", "count"])
    writer.writerows(["-".join(face.struts), face.count] for face in table.faces)
    if table.cuts is not None:
        writer.writerow([])
        writer.writerow(["bars", "struts", "rest"])
        for bar in table.cuts.bars:
            writer.writerow([bar.count, " ".join(bar.struts), LENGTH.format(bar.rest)])
    writer.writerow([])
    writer.writerow(
        ["edge", "from", "to", "type", "length", "cut length", "dihedral", "bend at from", "bend at to"]
    )
    for e, (a, b) in enumerate(table.edges.tolist()):
        one, dihedral = table.struts[table.types[e]], table.dihedral_angles[e]
        lengths = [LENGTH.format(value) for value in (table.lengths[e], one.cut_length)]
        bent = ["" if np.isnan(dihedral) else ANGLE.format(dihedral), *map(ANGLE.format, table.bends[e])]
        writer.writerow([e, a, b, one.name, *lengths, *bent])
    writer.writerow([])
    writer.writerow(["vertex", "hub"])
    writer.writerows([v, table.hubs[k].name] for v, k in enumerate(table.hub_types.tolist()) if k >= 0)
    return file.getvalue()


def text(table: StrutTable) -> str:
    """Tables of types, for the screen."""
    on_sphere, shorter = table.radius is not None, table.hub_radius > 0
    header = ["strut", "count", "length"] + ["cut length"] * shorter
    header += ["chord factor", "central angle"] * on_sphere
    rows = []
    for one in table.struts:
        numbers = [f"{one.length:.6g}"] + [f"{one.cut_length:.6g}"] * shorter
        if one.chord_factor is not None and one.central_angle is not None:
            numbers += [f"{one.chord_factor:.5f}", f"{one.central_angle:.3f}"]
        rows.append([one.name, str(one.count), *numbers])
    parts = [table.summary, _aligned(header, rows)]
    hubs = [
        [
            hub.name,
            str(hub.count),
            _steps(hub.angles),
            _steps(hub.bends),
            _steps(hub.strut_angles),
            "-".join(hub.struts) + " (boundary)" * hub.is_on_boundary,
        ]
        for hub in table.hubs
    ]
    parts.append(_aligned(["hub", "count", "angles", "bends", "strut angles", "struts"], hubs))
    faces = [["-".join(face.struts), str(face.count)] for face in table.faces]
    parts.append(_aligned(["face", "count"], faces))
    if table.cuts is not None:
        parts.append(str(table.cuts))
    return "\n\n".join(parts)


def _steps(angles: Sequence[float]) -> str:
    """Range of angles, as text."""
    if not angles:
        return ""
    smallest, largest = (f"{value:.2f}" for value in (min(angles), max(angles)))
    return smallest if smallest == largest else f"{smallest} to {largest}"


def _aligned(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(row[k]) for row in (header, *rows)) for k in range(len(header))]
    last = len(header) - 1
    return "\n".join(
        "  ".join(
            word.ljust(width) if k == 0 or k == last > 1 else word.rjust(width)
            for k, (word, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (header, *rows)
    )
