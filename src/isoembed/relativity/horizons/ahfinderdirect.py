"""Horizon shapes that AHFinderDirect of the Einstein Toolkit writes: files h.t<iteration>.ah<number>.gp.

They hold the radius of the horizon about an origin on up to six patches of an inflated cube [1]_, and points
in the coordinates of the slice; no metric.  Runs with symmetries write fewer patches.

References
----------
.. [1] J. Thornburg, "A fast apparent-horizon finder for three-dimensional Cartesian grids in numerical
   relativity", Classical and Quantum Gravity 21 (2004), 743-766.
"""

from __future__ import annotations

import gzip
import itertools
import os
import re
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from isoembed.io.files import FileError, check_input
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape, triangulate_star_shaped
from isoembed.smooth.harmonics import Harmonics

Floats = NDArray[np.float64]

ANGLE = 1e-3
"""In degrees: what the printed digits may move a point; the steps of a grid are far longer."""

SEAM = 1e-4
"""In radians: how far apart the printed digits may put a point that is in two patches."""

RADIUS = 1e-5
"""Relative difference of a printed radius and the distance of the printed point from the origin."""

DEGREE = 8
"""Of the harmonics that tell a smooth surface from one with a crease along a plane of symmetry."""

CREASED = 1e-3
"""What harmonics miss, relative to the radius, from which on it is asked whether more of them miss less."""

HEADER = re.compile(r"[#%!;\"]+\s*(N_patches|origin|N_rho|N_sigma)\b\s*[=:]?\s*(.*)", re.IGNORECASE)
PATCH = re.compile(r"[#%!;\"]+\s*([+-][xyz])[\s_-]*patch", re.IGNORECASE)


@dataclass
class _Patch:
    """The rows of one patch as they are being read: lines, radii and points."""

    name: str
    line: int
    sizes: dict[str, int] = field(default_factory=dict)
    lines: list[int] = field(default_factory=list)
    rows: list[list[float]] = field(default_factory=list)

    @property
    def axis(self) -> tuple[int, int]:
        """Which of x, y and z, and its sign."""
        return "xyz".index(self.name[1]), 1 if self.name[0] == "+" else -1


@dataclass(frozen=True)
class _Symmetry:
    """How the part that a file holds is completed: the images (3, 3) of it, and what they are called."""

    images: list[Floats]
    name: str


def read_ahfinderdirect(path: str | os.PathLike[str]) -> CoordinateShape:
    """Read a horizon's shape as AHFinderDirect writes it, and make it one closed surface.

    Ghost zones are dropped, points on the seams of patches merged, and what a symmetric run leaves out is
    completed: by reflections in the planes z = 0, x = 0 and y = 0 of the origin, or by rotations about the
    z-axis, whichever gives the smooth surface.

    Parameters
    ----------
    path : path
        ``h.t*.ah*.gp``, which may be compressed (``.gz``).

    Returns
    -------
    CoordinateShape
        Its time is None: the number behind ``t`` in the name of the file counts iterations.

    Raises
    ------
    FileError
        The file cannot be read, is cut short or malformed (the message names the line), patches are missing
        that no symmetry supplies, or none of those that may completes a smooth surface.
    """
    path = Path(path)
    origin, patches = _patches(path)
    widest = max(_overhang(patch, origin) for patch in patches)
    halves = _halves(patches, origin, widest, path)
    arrows = [_trimmed(patch, origin, halves) for patch in patches]
    for patch, arrow in zip(patches, arrows, strict=True):
        if len(arrow) == 0:
            raise FileError(f"{path}: no point of the patch {patch.name} is in the direction {patch.name}")
    arrow = _completed(np.concatenate(arrows), halves, path)
    points = origin + arrow
    kept, faces = triangulate_star_shaped(points, origin, str(path), same=SEAM)
    name = re.search(r"ah\d+", path.name)
    return CoordinateShape(points[kept], faces, origin, None, name[0] if name else "", str(path))


def text_of(path: Path) -> str:
    """The text of a file, decompressed if it is compressed.

    Raises
    ------
    FileError
        It cannot be read, or is not text.
    """
    check_input(path)
    try:
        data = path.read_bytes()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        return data.decode("utf-8")
    except (OSError, EOFError, zlib.error) as error:
        raise FileError(f"cannot decompress {path}: {error}") from None
    except UnicodeDecodeError:
        raise FileError(f"{path} is not a text file") from None


def is_shape(text: str) -> bool:
    """Whether a text begins like a shape file."""
    return any(
        match and match[1].lower() == "n_patches" for match in map(HEADER.match, text.splitlines()[:200])
    )


def _patches(path: Path) -> tuple[Floats, list[_Patch]]:
    text = text_of(path)
    if not is_shape(text):
        raise FileError(
            f"{path} has no line '# N_patches = ...': it is not a shape file of AHFinderDirect (h.t*.ah*.gp)"
        )
    count, origin, patches = 0, np.full(3, np.nan), list[_Patch]()
    number = 0
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if header := HEADER.match(line.strip()):
            key, value = header[1].lower(), header[2].replace(",", " ").split()
            numbers = _numbers(value, path, number)
            wanted = 3 if key == "origin" else 1
            if len(numbers) != wanted or not np.isfinite(numbers).all():
                raise FileError(
                    f"{path}, line {number}: {line.strip()!r} does not give {wanted} finite numbers"
                )
            if key == "origin":
                origin = np.array(numbers)
            elif key == "n_patches":
                count = int(numbers[0])
            elif patches:
                patches[-1].sizes[key] = int(numbers[0])
        elif title := PATCH.match(line.strip()):
            patches.append(_Patch(title[1].lower(), number))
            if patches[-1].name in [other.name for other in patches[:-1]]:
                raise FileError(f"{path}, line {number}: the patch {patches[-1].name} is there twice")
        elif words[0][0] not in '#%!;"':
            if len(words) != 6:
                raise FileError(f"{path}, line {number}: there are {len(words)} columns, not 6")
            if not patches or not np.isfinite(origin).all():
                raise FileError(f"{path}, line {number}: numbers before the origin or the name of a patch")
            row = _numbers(words, path, number)
            r, distance = row[2], float(np.linalg.norm(np.array(row[3:]) - origin))
            room = RADIUS * r + 1e-9 * float(np.max(np.abs(origin)))
            if not (np.isfinite(row).all() and r > 0 and abs(r - distance) <= room):
                raise FileError(
                    f"{path}, line {number}: the radius is {r:.6g}, but the point is at the distance "
                    f"{distance:.6g} from the origin"
                )
            patches[-1].lines.append(number)
            patches[-1].rows.append(row)
    for patch in patches:
        _check_size(patch, path)
    if len(patches) != count or not patches:
        raise FileError(f"{path} ends at line {number} after {len(patches)} of {count} patches")
    return origin, patches


def _numbers(words: list[str], path: Path, line: int) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise FileError(f"{path}, line {line}: {error}") from None


def _check_size(patch: _Patch, path: Path) -> None:
    """As many rows as the header says, with or without the ghost zones around them."""
    rho, sigma = patch.sizes.get("n_rho", 0), patch.sizes.get("n_sigma", 0)
    rows = len(patch.rows)
    allowed = {(rho + 2 * ghosts) * (sigma + 2 * ghosts) for ghosts in range(9)} if rho and sigma else {rows}
    if rows == 0 or rows not in allowed:
        end = patch.lines[-1] if patch.lines else patch.line
        raise FileError(
            f"{path}, line {end}: the patch {patch.name} ends after {rows} rows; "
            f"{rho} x {sigma} of them are announced"
        )


def _overhang(patch: _Patch, origin: Floats) -> float:
    """By how much ghost zones reach beyond 45 degrees from the middle of a patch, in degrees."""
    axis, sign = patch.axis
    arrow = np.array(patch.rows)[:, 3:] - origin
    others = [abs(arrow[:, i]) for i in range(3) if i != axis]
    return max(0.0, float(np.degrees(np.max(np.arctan2(others, sign * arrow[:, axis])))) - 45.0)


def _halves(patches: list[_Patch], origin: Floats, widest: float, path: Path) -> dict[int, int]:
    """The axes of which only one half is there, and the sign of that half."""
    there = {patch.axis for patch in patches}
    halves = {}
    for axis in range(3):
        missing = [sign for sign in (1, -1) if (axis, sign) not in there]
        if len(missing) == 2:
            raise FileError(f"{path} has neither the patch +{'xyz'[axis]} nor the patch -{'xyz'[axis]}")
        for sign in missing:
            for patch in patches:
                beyond = sign * (np.array(patch.rows)[:, 3 + axis] - origin[axis])
                along = np.linalg.norm(np.array(patch.rows)[:, 3:] - origin, axis=1)
                angle = float(np.degrees(np.max(np.arcsin(np.clip(beyond / along, -1.0, 1.0)))))
                if patch.axis[0] != axis and angle > min(widest, 44.0) + ANGLE:
                    letter = "xyz"[axis]
                    raise FileError(
                        f"{path}: the patch {'+-'[sign < 0]}{letter} is missing, and no reflection supplies "
                        f"it, as the patch {patch.name} reaches across {letter} = {origin[axis]:.6g}"
                    )
            halves[axis] = -sign
    return halves


def _trimmed(patch: _Patch, origin: Floats, halves: dict[int, int]) -> Floats:
    """The points of a patch relative to the origin, without ghost zones."""
    arrow = np.array(patch.rows)[:, 3:] - origin
    axis, sign = patch.axis
    near = sign * arrow[:, axis]
    room = np.radians(ANGLE) * np.linalg.norm(arrow, axis=1)
    keep = np.ones(len(arrow), dtype=bool)
    for i in range(3):
        if i != axis:
            keep &= np.abs(arrow[:, i]) <= near + room
        if i in halves:
            keep &= halves[i] * arrow[:, i] >= -room
    return arrow[keep]


def _completed(arrow: Floats, halves: dict[int, int], path: Path) -> Floats:
    """The points and their images under the symmetry that fits them."""
    if 2 in halves:
        arrow = _images(arrow, [np.eye(3), np.diag([1.0, 1.0, -1.0])])
    candidates = _symmetries(halves)
    if len(candidates) == 1:
        return _images(arrow, candidates[0].images)
    completed = [_images(arrow, candidate.images) for candidate in candidates]
    misses = [_miss(points, DEGREE) for points in completed]
    best = int(np.argmin(misses))
    # Half as many degrees again: a crease goes with 1 / degree, what is smooth exponentially.
    if misses[best] > CREASED and _miss(completed[best], 3 * DEGREE // 2) > 0.5 * misses[best]:
        names = " nor ".join(candidate.name for candidate in candidates)
        raise FileError(
            f"{path}: only a part of the surface is there, and neither {names} make it a smooth surface "
            f"(creases of {misses[best]:.1g} of its radius)"
        )
    return completed[best]


def _symmetries(halves: dict[int, int]) -> list[_Symmetry]:
    """What may complete the surface, once it is complete in z."""
    one = np.eye(3)
    horizontal = [axis for axis in (0, 1) if axis in halves]
    if not horizontal:
        return [_Symmetry([one], "nothing")]
    mirrors = []
    for signs in itertools.product((1.0, -1.0), repeat=len(horizontal)):
        image = one.copy()
        image[horizontal, horizontal] = signs
        mirrors.append(image)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    power = 1 if len(horizontal) == 2 else 2
    turns = [np.linalg.matrix_power(quarter, k) for k in range(0, 4, power)]
    return [_Symmetry(mirrors, "reflections"), _Symmetry(turns, f"rotations by {90 * power} degrees")]


def _images(arrow: Floats, images: list[Floats]) -> Floats:
    return np.concatenate([arrow @ image.T for image in images])


def _miss(arrow: Floats, degree: int) -> float:
    """By how much the best fit of log r in harmonics misses it at most."""
    r = np.linalg.norm(arrow, axis=1)
    Y = Harmonics(degree, degree).values(arrow / r[:, None])
    log = np.log(r / np.max(r))
    return float(np.max(np.abs(Y @ np.linalg.lstsq(Y, log, rcond=None)[0] - log)))
