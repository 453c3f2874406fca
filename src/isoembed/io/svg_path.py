"""Conversion of SVG path data (line segments, Bezier curves and elliptical arcs) to polylines."""

import math
import re

import numpy as np

from isoembed.arrays import Floats

TOKEN = re.compile(r"([MmLlHhVvCcSsQqTtAaZz])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|([\s,]+)")
FLAG = re.compile("[01]")
COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
LARGEST = 1e30
FLATNESS = 1e-4  # distance between a curve and its chords, relative to its extent
MOST_READ = 100_000  # elements of a drawing, counted once per use: nested references can make billions


def path_points(d: str) -> tuple[list[tuple[Floats, bool]], Floats, int]:
    """Sample a path.

    Parameters
    ----------
    d : str
        Commands of the path.

    Returns
    -------
    list of (ndarray of shape (n, 2), bool)
        Points of each subpath, and whether it is closed.
    ndarray
        Numbers of the path data that are coordinates.
    int
        Largest number of consecutive relative commands, at least 1; their rounding errors accumulate.

    Raises
    ------
    ValueError
        The path is invalid.
    """
    tokens = _tokens(d)
    parts: list[tuple[Floats, bool]] = []
    points: list[complex] = []
    exact: list[float] = []
    at = start = handle = 0j
    before, relative, longest = "", 0, 1
    k = 0
    command = ""
    while k < len(tokens):
        if isinstance(tokens[k], str):
            command = str(tokens[k])
            k += 1
        elif command in "Zz":
            raise ValueError(f"a path goes on after its end: {d[:40]!r}")
        elif command in "Mm":
            command = "L" if command == "M" else "l"
        kind = command.upper()
        values = tokens[k : k + COUNTS[kind]]
        if len(values) < COUNTS[kind] or any(isinstance(v, str) for v in values):
            raise ValueError(f"the command {command} of a path lacks numbers: {d[:40]!r}")
        x = [float(v) for v in values]
        k += len(x)
        exact += x[5:] if kind == "A" else x
        relative = relative + 1 if command.islower() and kind != "Z" else 0
        longest = max(longest, relative)
        base = at if command.islower() else 0j
        if kind == "M":
            if points:
                parts.append((_array(points), False))
            at = start = base + complex(*x)
            points = [at]
        elif kind == "Z":
            if points:
                parts.append((_array(points), True))
            at, points = start, []
        else:
            if not points:
                points = [at]
            if kind in "LHV":
                end = (
                    base + complex(*x)
                    if kind == "L"
                    else (
                        complex(x[0] + base.real, at.imag)
                        if kind == "H"
                        else complex(at.real, x[0] + base.imag)
                    )
                )
                new = [end]
            elif kind == "A":
                new = _arc(at, x, base + complex(*x[5:]))
            else:
                ends = [base + complex(*x[i : i + 2]) for i in range(0, len(x), 2)]
                smooth = kind in "ST"
                if smooth:
                    follows = before in ("CS" if kind == "S" else "QT")
                    ends.insert(0, 2 * at - handle if follows else at)
                handle = ends[-2]
                new = _bezier([at, *ends])
            points += new
            at = new[-1]
        before = kind
    if points:
        parts.append((_array(points), False))
    return parts, np.array(exact), longest


def _tokens(d: str) -> list[str | float]:
    """Letters and numbers; the flags of an arc need no separator."""
    found: list[str | float] = []
    letter, count, end = "", 0, 0
    while end < len(d):
        flag = letter in ("A", "a") and count % COUNTS["A"] in (3, 4) and d[end] in "01"
        match = FLAG.match(d, end) if flag else TOKEN.match(d, end)
        if match is None:
            raise ValueError(f"a path has {d[end : end + 10]!r}")
        end = match.end()
        if flag:
            found.append(float(match[0]))
            count += 1
        elif match[1]:
            letter, count = match[1], 0
            found.append(letter)
        elif match[2]:
            found.append(number(match[2]))
            count += 1
    if found and found[0] not in ("M", "m"):
        raise ValueError(f"a path does not begin with M: {d[:40]!r}")
    return found


def number(text: str) -> float:
    """Number of a drawing.

    Raises
    ------
    ValueError
        The number is so large that areas overflow.
    """
    value = float(text)
    if not abs(value) < LARGEST:
        raise ValueError(f"the number {text[:40]} is too large")
    return value


def _array(points: list[complex]) -> Floats:
    some = np.array(points)
    return np.column_stack([some.real, some.imag])


def _bezier(corners: list[complex]) -> list[complex]:
    """Points of a Bezier curve after the first; the second derivative bounds the error of the chords."""
    p = np.array(corners)
    degree = len(p) - 1
    second = degree * (degree - 1) * np.abs(np.diff(p, 2)).max()
    size = float(np.abs(p - p[0]).max())
    n = max(1, math.ceil(math.sqrt(second / (8 * FLATNESS * size)))) if size > 0 else 1
    t = np.arange(1, n + 1) / n
    weights = [math.comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)]
    found = sum(w * c for w, c in zip(weights, p, strict=True))
    return [*np.asarray(found)[:-1].tolist(), corners[-1]]


def _arc(at: complex, x: list[float], end: complex) -> list[complex]:
    """Points of an elliptical arc after the first, from endpoint parameters (SVG 2, B.2.4)."""
    rx, ry, turn = abs(x[0]), abs(x[1]), complex(math.cos(math.radians(x[2])), math.sin(math.radians(x[2])))
    large, sweep = bool(x[3]), bool(x[4])
    if rx == 0 or ry == 0 or at == end:
        return [end]
    half = (at - end) / 2 / turn
    u, v = half.real / rx, half.imag / ry
    grow = u * u + v * v
    if grow > 1:
        rx, ry, u, v, grow = (
            rx * math.sqrt(grow),
            ry * math.sqrt(grow),
            u / math.sqrt(grow),
            v / math.sqrt(grow),
            1.0,
        )
    factor = math.sqrt(max(0.0, 1 / grow - 1)) * (-1 if large == sweep else 1)
    center = complex(factor * v, -factor * u)  # in coordinates of the unit circle, from the chord's midpoint
    first = math.atan2(v - center.imag, u - center.real)
    last = math.atan2(-v - center.imag, -u - center.real)
    angle = (last - first) % (2 * math.pi) if sweep else -((first - last) % (2 * math.pi))
    n = max(2, math.ceil(abs(angle) / math.sqrt(8 * FLATNESS)))
    t = first + angle * np.arange(1, n) / n
    cx, cy = center.real * rx, center.imag * ry
    found = (at + end) / 2 + turn * ((cx + rx * np.cos(t)) + 1j * (cy + ry * np.sin(t)))
    return [*found.tolist(), end]
