"""Reader for slices in Chombo HDF5 files, the checkpoints and plot files of GRChombo.

The root has the names of the variables as attributes ``component_0`` ..., and each group ``level_N`` has its
spacing ``dx``, its boxes, and for each box the values of all variables one after the other, x running
fastest, with as many ghost zones as ``data_attributes`` says [1]_.  Cell [i, j, k] is at
``dx (i + 1/2, j + 1/2, k + 1/2)``: the lower corner of the usual domain is the origin.  Ghost zones tell only
whether the domain ends at a mirror.

References
----------
.. [1] M. Adams et al., "Chombo software package for AMR applications: design document", Lawrence Berkeley
   National Laboratory report LBNL-6616E (2015).
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.io.files import FileError
from isoembed.io.hdf5 import check_data_set, text_of
from isoembed.io.input_file import InputFile
from isoembed.relativity.series.adm_variables import GRCHOMBO, AdmVariables, rank, variables_in
from isoembed.relativity.series.amr_grid import PatchSlice
from isoembed.relativity.series.grid_symmetry import AxisMap, reflections
from isoembed.relativity.series.moment import ListedFile, best_of_moments
from isoembed.relativity.series.refined_grid import Component, beyond_ghosts

GLOBAL = "Chombo_global"
COMPONENT = re.compile(r"component_(\d+)")
KNOWN = (GRCHOMBO, AdmVariables())
DATA, OFFSETS = "data:datatype=0", "data:offsets=0"


def is_chombo(path: Path) -> bool:
    """Whether an HDF5 file is of Chombo.  Raises `FileError`: it cannot be read."""
    with InputFile(path) as file:
        return GLOBAL in file.names


def chombo_slices(paths: Iterable[Path]) -> list[ListedFile]:
    """Slices of files; at each time those with the best complete set of variables, or the first if none has.

    Raises `FileError`: one of them cannot be read.
    """
    out = []
    for path in paths:
        with InputFile(path) as file, file.hdf5() as root:
            time = root.attrs.get("time", root["level_0"].attrs.get("time"))
            iteration = root.attrs.get("iteration")
            order = rank(_names(root), KNOWN)
        listed = ListedFile(
            None if iteration is None else int(iteration),
            None if time is None else float(time),
            ChomboSlice((str(path),)),
        )
        out.append((order, listed))
    return best_of_moments(out, len(KNOWN))


@dataclass(frozen=True)
class ChomboSlice(PatchSlice):
    """Slice of one file of Chombo."""

    def data(self, closing: contextlib.ExitStack) -> _Data:
        """See `PatchSlice`."""
        file = closing.enter_context(InputFile(self.paths[0]))
        return _Data(self.name, closing.enter_context(file.hdf5()))


class _Data:
    """Data of a file as `PatchData`."""

    def __init__(self, name: str, root: Any) -> None:
        self.name = name
        self._root = root
        if (dimensions := int(root[GLOBAL].attrs["SpaceDim"])) != 3:
            raise FileError(f"{name} has {dimensions} dimensions of space, not three")
        names = _names(root)
        self._variables = variables_in(names, KNOWN, name)
        self._columns = [names[each] for each in self._variables.names]
        self._count = int(root.attrs["num_components"])

    @cached_property
    def symmetry(self) -> tuple[AxisMap, ...]:
        return reflections(axis for axis in range(3) if self._is_mirror(axis))

    @cached_property
    def levels(self) -> list[int]:
        return list(range(int(self._root.attrs["num_levels"])))

    def components(self, level: int) -> list[Component]:
        found = self._levels.get(level)
        if found is None:
            found = self._levels[level] = self._components(level)
        return found

    def values(self, level: int, component: Component, part: tuple[slice, ...]) -> Floats:
        start, ghosts = component.key
        nx, ny, nz = (n + 2 * g for n, g in zip(component.shape, ghosts, strict=True))
        i, j, k = beyond_ghosts(part, ghosts)
        data = self._root[f"level_{level}"][DATA]
        rows = []
        for column in self._columns:
            first = start + column * nx * ny * nz
            planes = data[first + k.start * nx * ny : first + k.stop * nx * ny]
            rows.append(planes.reshape(-1, ny, nx)[:, j, i].transpose())
        return self._variables.adm(np.stack(rows).astype(np.float64))

    def _is_mirror(self, axis: int) -> bool:
        """Whether the domain ends at a mirror, the plane of zero coordinate along an axis.

        This is not in the file, but ghost zones, if written, are copies of the cells on the other side of
        such a plane, with the signs of the components.
        """
        if _triples(self._root["level_0"].attrs["prob_domain"], "lo_")[axis] != 0:
            return False
        image = reflections([axis])[1]
        signs = np.array([image.entry(row % 6)[1] for row in range(12)])
        varies = False
        for component in self.components(0):
            ghosts = component.key[1][axis]
            if component.origin[axis] < component.spacing[axis]:
                if ghosts < 2:  # a single ghost cell may also be a constant extrapolation
                    return False
                part = [slice(0, n) for n in component.shape]
                part[axis] = slice(-ghosts, ghosts)
                fields = np.moveaxis(self.values(0, component, tuple(part)), axis + 1, -1)
                mirrored = fields[..., ::-1] * signs[:, None, None, None]
                if not np.array_equal(fields, mirrored, equal_nan=True):
                    return False
                varies = varies or bool((fields[..., ghosts] != fields[..., ghosts + 1]).any())
        return varies

    @cached_property
    def _levels(self) -> dict[int, list[Component]]:
        return {}

    def _components(self, level: int) -> list[Component]:
        group = self._root[f"level_{level}"]
        boxes = group["boxes"][()]
        low, high = (_triples(boxes, end) for end in ("lo_", "hi_"))
        ghosts = _triples(np.asarray(group["data_attributes"].attrs["outputGhost"]), "intvect")
        offsets, data = group[OFFSETS][()], group[DATA]
        check_data_set(data, self.name, data.nbytes)
        shapes = high - low + 1
        expected = self._count * np.prod(shapes + 2 * ghosts, axis=1)
        sizes = np.diff(offsets)
        if len(offsets) != len(boxes) + 1 or (sizes != expected).any() or offsets[-1] != data.size:
            raise FileError(f"{self.name}: the data of level {level} do not fit its {len(boxes)} boxes")
        spacing = float(group.attrs["dx"])
        g = tuple(ghosts.ravel().tolist())
        return [
            Component.of((int(offsets[b]), g), spacing * (low[b] + 0.5), [spacing] * 3, shapes[b])
            for b in range(len(boxes))
        ]


def _names(root: Any) -> dict[str, int]:
    """Indices of the variables by name."""
    components = ((COMPONENT.fullmatch(key), value) for key, value in root.attrs.items())
    return {text_of(value): int(match[1]) for match, value in components if match}


def _triples(structured: Any, prefix: str) -> Indices:
    """Fields such as lo_i, lo_j and lo_k of a structured array, (..., 3)."""
    return np.stack([structured[prefix + axis] for axis in "ijk"], axis=-1).astype(np.int64)
