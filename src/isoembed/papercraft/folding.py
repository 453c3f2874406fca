"""Partial folding of a net: positions of its faces at a fraction of the fold angles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.gluing.creases import fold_up
from isoembed.gluing.polygon import consecutive
from isoembed.mesh.triangulation import frozen

if TYPE_CHECKING:
    from isoembed.gluing.unfolding import Unfolding


def partly_folded(unfolding: Unfolding, share: float) -> tuple[Floats, list[Indices]]:
    """Fold the sheets of a net by a fraction of each fold angle.

    The central face of each sheet stays in place, in the plane z = 0, with the outside of the solid up.
    Sheets are not assembled.

    Parameters
    ----------
    unfolding : Unfolding
    share : float
        Fraction: 0 for the flat net, 1 for the solid.

    Returns
    -------
    vertices : ndarray, shape (n, 3)
        Concatenated corners of the sheets.
    faces : list of ndarray of int64
        Vertices around each face.

    Raises
    ------
    InvalidParameter
        The fraction is not a finite number.

    Examples
    --------
    A half-folded cube:

    >>> import isoembed
    >>> corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    >>> vertices, faces = partly_folded(isoembed.unfold((corners, squares)), 0.5)
    >>> len(vertices), len(faces)
    (14, 6)
    """
    if not np.isfinite(share):
        raise InvalidParameter(f"the fraction of the fold angles is {share!r}, not a finite number")
    vertices, every, first = [], [], 0
    for sheet, around, ends, bent in zip(
        unfolding.sheets, unfolding.faces, unfolding.fold_corners, unfolding.angles, strict=True
    ):
        faces = _from_the_middle(sheet, around)
        angles = {(min(ends), max(ends)): 0.0 for face in faces for ends in consecutive(face)}
        for (a, b), angle in zip(ends.tolist(), bent.tolist(), strict=True):
            angles[min(a, b), max(a, b)] = -share * angle  # `fold_up` takes valleys as positive
        places, _ = fold_up(sheet, [face.tolist() for face in faces], angles, np.inf)
        vertices.append(places)
        every += [frozen(face + first) for face in faces]
        first += len(sheet)
    return frozen(np.concatenate(vertices)), every


def _from_the_middle(sheet: Floats, faces: tuple[Indices, ...]) -> list[Indices]:
    """Faces of a sheet, the central one first."""
    low, high = sheet.min(axis=0), sheet.max(axis=0)
    off = [np.linalg.norm(sheet[face].mean(axis=0) - (low + high) / 2) for face in faces]
    k = int(np.argmin(off))
    return [faces[k], *faces[:k], *faces[k + 1 :]]
