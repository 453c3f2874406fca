"""Reader for horizon shapes of AHFinderDirect (Einstein Toolkit), h.t<iteration>.ah<number>.gp.

A file holds the radius of the horizon about an origin on up to six patches of an inflated cube [1]_ and the
points in slice coordinates, but no metric.  Runs with symmetries write fewer patches.

References
----------
.. [1] J. Thornburg, "A fast apparent-horizon finder for three-dimensional Cartesian grids in numerical
   relativity", Classical and Quantum Gravity 21 (2004), 743-766.
"""

import itertools
import os
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.io.input_file import InputFile, opened
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape, triangulate_star_shaped
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.smooth.harmonics import Harmonics

HEADER = re.compile(r"[#%!;\"]+\s*(N_patches|origin|N_rho|N_sigma)\b\s*[=:]?\s*(.*)", re.IGNORECASE)
PATCH = re.compile(r"[#%!;\"]+\s*([+-][xyz])[\s_-]*patch", re.IGNORECASE)
DIGITS = 1e-3  # angular error of printed points, in degrees
SMOOTH_DEGREE = 8  # degree of the harmonics that distinguish a smooth surface from one with a crease


@dataclass
class _Patch:
    """Partially read patch: its last line, announced sizes, and rows."""

    name: str
    line: int
    sizes: dict[str, int] = field(default_factory=dict)
    rows: list[list[float]] = field(default_factory=list)


def read_ahfinderdirect(path: str | os.PathLike[str]) -> CoordinateShape:
    """Read the closed coordinate surface of a horizon from a file of AHFinderDirect.

    Ghost zones are dropped, and points on the seams between patches are merged.  Parts omitted by a symmetric
    run are completed by reflections in the planes z = 0, x = 0 and y = 0 through the origin, or by rotations
    about the z-axis, whichever gives a smooth surface.

    Parameters
    ----------
    path : path
        ``h.t*.ah*.gp``, optionally compressed (``.gz``).

    Returns
    -------
    CoordinateShape
        The iteration is the number after ``t`` in the file name; the time is None.

    Raises
    ------
    FileError
        The file cannot be read, is truncated or malformed (the message names the line), no symmetry supplies
        the missing patches, or none of the candidate symmetries gives a smooth surface.
    """
    with opened(path) as file:
        origin, arrows = _patches(file)
    name, iteration = horizon_and_iteration(file.path)
    return replace(shape_of_patches(origin, arrows, str(file)), name=name, iteration=iteration)


def horizon_and_iteration(path: Path) -> tuple[str, int | None]:
    """Horizon name, such as "ah1", and iteration from a file name h.t<iteration>.ah<number>.gp."""
    horizon, iteration = (re.search(pattern, path.name) for pattern in (r"ah\d+", r"\.t(\d+)\."))
    return horizon[0] if horizon else "", int(iteration[1]) if iteration else None


def shape_of_patches(origin: Floats, arrows: dict[str, Floats], source: str) -> CoordinateShape:
    """Closed surface from patches of an inflated cube, with or without ghost zones, completed by symmetry.

    Raises `FileError`: no symmetry supplies the missing patches, or none of the candidate symmetries gives a
    smooth surface.

    Parameters
    ----------
    origin : ndarray, shape (3,)
    arrows : dict of str to ndarray, shape (n, 3)
        Points of each patch relative to the origin, keyed by the axis of the patch, such as "+z".
    source : str
        Name of the source, for messages.
    """
    halves = _halves(arrows, origin, source)
    trimmed = {name: _trimmed(name, arrow, halves) for name, arrow in arrows.items()}
    for name, arrow in trimmed.items():
        if len(arrow) == 0:
            raise FileError(f"{source}: no point of the patch {name} is in the direction {name}")
    points = origin + _completed(np.concatenate(list(trimmed.values())), halves, source)
    # Copies of a point in two patches differ by the rounding of printed digits.
    indices, faces = triangulate_star_shaped(points, origin, source, same=1e-4)
    return CoordinateShape(points[indices], faces, origin, source=source, is_hull=True)


def _has_header(file: InputFile) -> bool:
    headers = map(HEADER.match, file.head.splitlines()[:200])
    return any(header and header[1].lower() == "n_patches" for header in headers)


def _patches(file: InputFile) -> tuple[Floats, dict[str, Floats]]:
    """Origin, and the points of each patch relative to it, keyed by the axis of the patch."""
    text = file.text
    if not _has_header(file):
        raise FileError(
            f"{file} has no line '# N_patches = ...': it is not a shape file of AHFinderDirect (h.t*.ah*.gp)"
        )
    count, origin, patches = 0, np.full(3, np.nan), dict[str, _Patch]()
    here = _Patch("", 0)
    number = 0

    def invalid_line(problem: str) -> FileError:
        return FileError(f"{file}, line {number}: {problem}")

    def floats(words: list[str]) -> list[float]:
        try:
            return [float(word) for word in words]
        except ValueError as error:
            raise invalid_line(str(error)) from None

    for number, line in enumerate(map(str.strip, text.splitlines()), 1):
        if not line:
            continue
        if header := HEADER.match(line):
            key, values = header[1].lower(), floats(header[2].replace(",", " ").split())
            wanted = 3 if key == "origin" else 1
            if len(values) != wanted or not np.isfinite(values).all():
                raise invalid_line(f"{line!r} does not give {wanted} finite numbers")
            if key == "origin":
                origin = np.array(values)
            elif key == "n_patches":
                count = int(values[0])
            else:
                here.sizes[key] = int(values[0])
        elif title := PATCH.match(line):
            here = _Patch(title[1].lower(), number)
            if here.name in patches:
                raise invalid_line(f"the patch {here.name} occurs twice")
            patches[here.name] = here
        elif line[0] not in '#%!;"':
            words = line.replace(",", " ").split()
            if len(words) != 6:
                raise invalid_line(f"there are {len(words)} columns, not 6")
            if not patches or not np.isfinite(origin).all():
                missing = "'### +z patch'" if patches == {} else "'# origin = x y z'"
                raise invalid_line(f"there are numbers before a line {missing}")
            row = floats(words)
            r, distance = row[2], float(np.linalg.norm(np.array(row[3:]) - origin))
            # Rounding of a printed radius, and of the distance from a remote origin.
            room = 1e-5 * r + 1e-9 * float(np.max(np.abs(origin)))
            if not (np.isfinite(row).all() and r > 0 and abs(r - distance) <= room):
                raise invalid_line(
                    f"the radius is {r:.6g}, but the point is at the distance {distance:.6g} from the origin"
                )
            here.line = number
            here.rows.append(row)
    for patch in patches.values():
        _check_size(patch, file)
    if len(patches) != count or not patches:
        raise FileError(f"{file} ends at line {number} after {len(patches)} of {count} patches")
    return origin, {name: np.array(patch.rows)[:, 3:] - origin for name, patch in patches.items()}


def _check_size(patch: _Patch, file: InputFile) -> None:
    """Check the number of rows against the header, with or without ghost zones."""
    rho, sigma = patch.sizes.get("n_rho", 0), patch.sizes.get("n_sigma", 0)
    rows, zones = len(patch.rows), range(9)  # at most eight ghost zones on each side of a patch
    allowed = {(rho + 2 * ghosts) * (sigma + 2 * ghosts) for ghosts in zones} if rho and sigma else {rows}
    if rows == 0 or rows not in allowed:
        raise FileError(
            f"{file}, line {patch.line}: the patch {patch.name} ends after {rows} rows; "
            f"{rho} x {sigma} are declared"
        )


def _axis(name: str) -> tuple[int, int]:
    """Index of the axis of a patch (x, y or z) and its sign."""
    return "xyz".index(name[1]), 1 if name[0] == "+" else -1


def _overhang(name: str, arrow: Floats) -> float:
    """Angular width of the ghost zones beyond 45 degrees from the center of a patch, in degrees."""
    axis, sign = _axis(name)
    others = np.abs(np.delete(arrow, axis, axis=1))
    return max(0.0, float(np.degrees(np.max(np.arctan2(others.T, sign * arrow[:, axis])))) - 45.0)


def _halves(arrows: dict[str, Floats], origin: Floats, source: str) -> dict[int, int]:
    """Axes with only one of two opposite patches, and the sign of that patch."""
    widest = max(_overhang(name, arrow) for name, arrow in arrows.items())
    halves = {}
    for axis, letter in enumerate("xyz"):
        missing = [sign for sign in (1, -1) if f"{'+-'[sign < 0]}{letter}" not in arrows]
        if len(missing) == 2:
            raise FileError(f"{source} has neither the patch +{letter} nor the patch -{letter}")
        for sign in missing:
            for name, arrow in arrows.items():
                sines = sign * arrow[:, axis] / np.linalg.norm(arrow, axis=1)
                angle = float(np.degrees(np.max(np.arcsin(np.clip(sines, -1.0, 1.0)))))
                # In degrees: a patch that ends before 45 does not cross the coordinate plane.
                if name[1] != letter and angle > min(widest, 44.0) + DIGITS:
                    raise FileError(
                        f"{source}: the patch {'+-'[sign < 0]}{letter} is missing, and no reflection "
                        f"supplies it, as the patch {name} reaches across {letter} = {origin[axis]:.6g}"
                    )
            halves[axis] = -sign
    return halves


def _trimmed(name: str, arrow: Floats, halves: dict[int, int]) -> Floats:
    """The points of a patch without ghost zones."""
    axis, sign = _axis(name)
    near = sign * arrow[:, axis]
    room = np.radians(DIGITS) * np.linalg.norm(arrow, axis=1)
    keep = np.ones(len(arrow), dtype=bool)
    for i in range(3):
        if i != axis:
            keep &= np.abs(arrow[:, i]) <= near + room
        if i in halves:
            keep &= halves[i] * arrow[:, i] >= -room
    return arrow[keep]


def _completed(arrow: Floats, halves: dict[int, int], source: str) -> Floats:
    """Points and their images under the symmetry that gives the smoothest surface."""
    if 2 in halves:
        arrow = _images(arrow, [np.eye(3), np.diag([1.0, 1.0, -1.0])])
    candidates = _symmetries(halves)
    completed = [_images(arrow, images) for images in candidates.values()]
    if len(completed) == 1:
        return completed[0]
    misses = [_miss(points, SMOOTH_DEGREE) for points in completed]
    best = int(np.argmin(misses))
    # At 1.5 times the degree: the misfit of a crease decays as 1 / degree, of a smooth surface exponentially.
    if (
        misses[best] > 1e-3  # mean radii: a smaller misfit is not a crease
        and _miss(completed[best], 3 * SMOOTH_DEGREE // 2) > 0.5 * misses[best]
    ):
        raise FileError(
            f"{source} has only part of the surface, and neither {' nor '.join(candidates)} complete it "
            f"smoothly (creases of {misses[best]:.1g} of its radius)"
        )
    return completed[best]


def _symmetries(halves: dict[int, int]) -> dict[str, list[Floats]]:
    """Matrices (3, 3) of the symmetries that may complete a surface already complete in z, by name."""
    one = np.eye(3)
    horizontal = [axis for axis in (0, 1) if axis in halves]
    if not horizontal:
        return {"nothing": [one]}
    mirrors = []
    for signs in itertools.product((1.0, -1.0), repeat=len(horizontal)):
        image = one.copy()
        image[horizontal, horizontal] = signs
        mirrors.append(image)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    power = 1 if len(horizontal) == 2 else 2
    turns = [np.linalg.matrix_power(quarter, k) for k in range(0, 4, power)]
    return {"reflections": mirrors, f"rotations by {90 * power} degrees": turns}


def _images(arrow: Floats, images: list[Floats]) -> Floats:
    return np.concatenate([arrow @ image.T for image in images])


def _miss(arrow: Floats, degree: int) -> float:
    """Largest residual of the least-squares fit of log r in harmonics."""
    r = np.linalg.norm(arrow, axis=1)
    Y = Harmonics(degree, degree).values(arrow / r[:, None])
    log = np.log(r / np.max(r))
    return float(np.max(np.abs(Y @ np.linalg.lstsq(Y, log, rcond=None)[0] - log)))


AHFINDERDIRECT = HorizonFormat(
    "AHFinderDirect", lambda file: file.ending == ".gp" or _has_header(file), read_ahfinderdirect
)
