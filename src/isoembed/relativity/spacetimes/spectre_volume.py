"""Reader for SpECTRE's volume data.

An observation holds the values at the nodes of all elements one after the other, the first axis of each
element running fastest: ``InertialCoordinates_x`` ..., ``SpatialMetric_xx``, ``_yx``, ... and maybe
``ExtrinsicCurvature_xx`` ...; ``total_extents``, ``bases`` and ``quadratures`` have three numbers for each
element, those of the last two being indices into the attributes ``Basis dictionary`` and ``Quadrature
dictionary``.  A run on several nodes writes as many files.  The sign of K_ij is that of
`isoembed.relativity.spacetimes.three_geometry`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.io.hdf5 import array_of, text_of
from isoembed.io.input_file import InputFile
from isoembed.relativity.spacetimes.checks import written
from isoembed.relativity.spacetimes.element_grid import BULGE, Element, ElementGrid
from isoembed.relativity.spacetimes.slice_file import PAIRS

GAMMA, K, POINTS = "SpatialMetric_", "ExtrinsicCurvature_", "InertialCoordinates_"
LAYOUT = ("total_extents", "bases", "quadratures")


def volume_times(path: str | os.PathLike[str]) -> list[float]:
    """Times in increasing order at which a file has the metric on elements; empty for other files.

    Raises `FileError`: the file cannot be read.
    """
    with InputFile(path) as source, source.hdf5() as file:
        return sorted(time for time, _ in _observations(file))


def read_spectre_volume(
    paths: Sequence[str | os.PathLike[str]], time: float, box: tuple[Floats, Floats] | None = None
) -> ElementGrid:
    """Read the slice at a time.

    Parameters
    ----------
    paths : sequence of paths
        All files of the run with elements at this time.
    time : float
        Time from `volume_times`.
    box : pair of ndarray, each of shape (3,), optional
        Lower and upper corner of a box; only elements that may intersect it are read.

    Raises
    ------
    FileError
        A file cannot be read or is incomplete, no element is in the box, or the basis of an element is not
        polynomial in all three directions.
    """
    elements = [element for path in paths for element in _elements(path, time, box)]
    if not elements:
        where = f" from {written(box[0])} to {written(box[1])}" if box else ""
        raise FileError(f"{' and '.join(map(str, paths))} have no elements{where} at t = {time:.9g}")
    return ElementGrid(elements)


def volume_arrays(path: str | os.PathLike[str], time: float) -> Iterator[tuple[str, NDArray[Any]]]:
    """Iterate over the names and arrays of a slice in one file.

    Raises `FileError`: see `read_spectre_volume`.
    """
    with InputFile(path) as source, source.hdf5() as file:
        group = _at(file, time, path)
        for name in sorted(map(str, group)):
            if name in LAYOUT or name.startswith((GAMMA, K, POINTS)):
                yield name, array_of(group[name], path)


def _elements(
    path: str | os.PathLike[str], time: float, box: tuple[Floats, Floats] | None
) -> Iterator[Element]:
    with InputFile(path) as source, source.hdf5() as file:
        group = _at(file, time, path)
        layout = [_layout(group, name, path) for name in LAYOUT]
        if len({len(numbers) for numbers in layout}) > 1:
            raise FileError(
                f"{path}: {' and '.join(LAYOUT)} are of {[len(part) for part in layout]} elements"
            )
        words = [_dictionary(group, f"{kind} dictionary", path) for kind in ("Basis", "Quadrature")]
        stops = np.cumsum(np.prod(layout[0], axis=1))
        points = [_values(group, POINTS + axis, stops, path) for axis in "xyz"]
        spans = list(zip([0, *stops[:-1]], stops, strict=True))
        wanted = [
            k
            for k, (start, stop) in enumerate(spans)
            if box is None or _is_near([axis[start:stop] for axis in points], *box)
        ]
        selected = np.concatenate([np.arange(*spans[k]) for k in wanted]) if wanted else np.arange(0)
        tensors = [name for name in (GAMMA, K) if any(f"{name}{pair}" in group for pair in PAIRS)]
        parts = [
            [axis[selected] for axis in points],
            *([_component(group, name, pair, stops, path)[selected] for pair in PAIRS] for name in tensors),
        ]
    start = 0
    for k in wanted:
        extents, basis, quadrature = (part[k] for part in layout)
        x, y, z = (
            _nodes(int(n), _word(words[0], b, path), _word(words[1], q, path), f"{path}: element {k}")
            for n, b, q in zip(extents, basis, quadrature, strict=True)
        )
        here = slice(start, start := start + math.prod(extents.tolist()))
        shaped = [
            np.stack([one[here].reshape(extents, order="F") for one in part], axis=-1) for part in parts
        ]
        yield Element((x, y, z), *shaped)


def _observations(file: Any) -> Iterator[tuple[float, Any]]:
    """Times and groups of volume data in an open file."""
    for name in file:
        if str(name).endswith(".vol") and file[name].attrs.get("dimension", 3) == 3:
            for group in (file[name][inner] for inner in file[name]):
                if "observation_value" in group.attrs and f"{GAMMA}xx" in group:
                    yield float(group.attrs["observation_value"]), group


def _at(file: Any, time: float, path: str | os.PathLike[str]) -> Any:
    found = [group for there, group in _observations(file) if there == time]
    if len(found) != 1:
        raise FileError(f"{path} has {len(found)} slices {GAMMA}xx ... at t = {time:.9g}, not one")
    return found[0]


def _layout(group: Any, name: str, path: str | os.PathLike[str]) -> NDArray[np.int64]:
    numbers = _array(group, name, path)
    if numbers.size % 3 or numbers.dtype.kind not in "iu" or (name == LAYOUT[0] and (numbers < 1).any()):
        raise FileError(f"{path}: {name} is not three counts for each element")
    return numbers.astype(np.int64).reshape(-1, 3)


def _array(group: Any, name: str, path: str | os.PathLike[str]) -> NDArray[Any]:
    if name not in group:
        raise FileError(f"{path} has no {name}")
    return np.asarray(array_of(group[name], path))


def _values(group: Any, name: str, stops: NDArray[np.int64], path: str | os.PathLike[str]) -> Floats:
    values = _array(group, name, path)
    total = int(stops[-1]) if len(stops) else 0
    if values.shape != (total,) or values.dtype.kind != "f":
        raise FileError(f"{path}: {name} is not one number for each of the {total} nodes")
    return values.astype(np.float64)


def _component(
    group: Any, name: str, pair: str, stops: NDArray[np.int64], path: str | os.PathLike[str]
) -> Floats:
    """Component of a symmetric tensor, named xy or yx."""
    turned = name + pair[::-1]
    return _values(group, turned if turned in group else name + pair, stops, path)


def _is_near(points: list[Floats], low: Floats, high: Floats) -> bool:
    """Whether an element may intersect a box."""
    lower, upper = (np.array([end(axis) for axis in points]) for end in (np.min, np.max))
    room = BULGE * (upper - lower)
    return bool(((upper + room >= low) & (lower - room <= high)).all())


def _dictionary(group: Any, name: str, path: str | os.PathLike[str]) -> list[str]:
    if name not in group.attrs:
        raise FileError(f"{path} has no {name}")
    return [text_of(word) for word in group.attrs[name]]


def _word(words: list[str], code: int, path: str | os.PathLike[str]) -> str:
    if not 0 <= code < len(words):
        raise FileError(f"{path}: {code} is not in the dictionary {', '.join(words)}")
    return words[code]


def _nodes(n: int, basis: str, quadrature: str, source: str) -> Floats:
    make = NODES.get((basis, quadrature))
    if make is None or (n < 2 and quadrature == "GaussLobatto"):
        raise FileError(
            f"{source} has {n} points of the basis {basis} and the quadrature {quadrature}: "
            "slices are read on Legendre or Chebyshev polynomials"
        )
    return make(n)


@lru_cache
def _legendre_lobatto(n: int) -> Floats:
    inner = legendre.legroots(legendre.legder([0.0] * (n - 1) + [1.0]))
    return np.concatenate([[-1.0], inner, [1.0]])


NODES: dict[tuple[str, str], Callable[[int], Floats]] = {
    ("Legendre", "Gauss"): lambda n: legendre.leggauss(n)[0],
    ("Legendre", "GaussLobatto"): _legendre_lobatto,
    ("Chebyshev", "Gauss"): lambda n: -np.cos((2 * np.arange(n) + 1) * np.pi / (2 * n)),
    ("Chebyshev", "GaussLobatto"): lambda n: -np.cos(np.arange(n) * np.pi / (n - 1)),
}
"""Nodes between -1 and 1, in increasing order."""
