"""HDF5 files as Carpet writes them, of slices in closed form."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from patch_data import fields

NAMES = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}
METRIC = [f"g{ij}" for ij in NAMES]
CURVATURE = [f"k{ij}" for ij in NAMES]
STALE = 1e3
EXCISED = 0.7


@dataclass(frozen=True)
class Level:
    """Points ``spacing * (i + shift)`` in boxes, each cut into pieces along one axis."""

    spacing: float
    boxes: tuple  # of pairs of corners, in coordinates
    pieces: int = 1
    axis: int = 0
    shift: float = 0.0

    def components(self):
        """First indices and numbers of points, without ghost zones."""
        for low, high in self.boxes:
            first = np.ceil(np.array(low) / self.spacing - self.shift - 1e-9).astype(int)
            last = np.floor(np.array(high) / self.spacing - self.shift + 1e-9).astype(int)
            cuts = np.linspace(first[self.axis], last[self.axis] + 1, self.pieces + 1).astype(int)
            for begin, end in pairwise(cuts):
                start, stop = first.copy(), last + 1
                start[self.axis], stop[self.axis] = begin, end
                yield start, stop - start


def cube(half, center=(0.0, 0.0, 0.0)):
    """Corners of a cube."""
    return tuple(c - half for c in center), tuple(c + half for c in center)


def sampled(geometry, level, start, shape, names, center=(0.0, 0.0, 0.0)):
    """Fields at points of a lattice; zero near the center, where holes have their singularities."""
    axes = [level.spacing * (np.arange(n) + s + level.shift) for s, n in zip(start, shape, strict=True)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    there = np.linalg.norm(x - np.array(center), axis=1) > EXCISED
    matrices = {"g": np.zeros((len(x), 3, 3)), "k": np.zeros((len(x), 3, 3))}
    matrices["g"][there], matrices["k"][there] = fields(geometry, x[there].tobytes())
    return {name: matrices[name[0]][(slice(None), *NAMES[name[1:]])].reshape(shape) for name in names}


def write_carpet(
    folder,
    geometry,
    levels,
    iteration=0,
    time=0.0,
    names=(*METRIC, *CURVATURE),
    parameters="",
    ghosts=3,
    stale=True,
    grouped=False,
    processes=1,
    kept=None,
):
    """Add an iteration to the files of a folder.

    `stale` fills ghost zones with what must not be read; `kept` restricts components to those with points in
    the part of space that a symmetric run has, by axis and sign.
    """
    import h5py

    folder.mkdir(parents=True, exist_ok=True)
    sets = {}
    for number, level in enumerate(levels):
        for c, (start, shape) in enumerate(_restricted(level, kept)):
            grown, whole = start - ghosts, shape + 2 * ghosts
            values = sampled(geometry, level, grown, tuple(whole), names)
            inside = tuple(slice(ghosts, ghosts + n) for n in shape)
            place = {
                "origin": level.spacing * (grown + level.shift),
                "delta": np.full(3, level.spacing),
                "time": float(time),
                "timestep": np.int32(iteration),
                "level": np.int32(number),
                "cctk_nghostzones": np.full(3, ghosts, dtype=np.int32),
                "iorigin": grown.astype(np.int32),
            }
            for name in names:
                data = values[name]
                if stale:
                    data = np.full_like(values[name], STALE)
                    data[inside] = values[name][inside]
                label = f"ADMBASE::{name} it={iteration} tl=0 rl={number} c={c}"
                there = sets.setdefault(_file(name, grouped, processes, c % processes), [])
                there.append((label, np.ascontiguousarray(data.T), place))
    for file_name, there in sets.items():
        with h5py.File(folder / file_name, "a") as file:
            _metadata(file, parameters, processes)
            for label, data, place in there:
                file.create_dataset(label, data=data).attrs.update(place)


def _restricted(level, kept):
    """Components without the points of the half that a symmetric run leaves out."""
    for start, shape in level.components():
        start, stop = start.copy(), start + shape
        for axis in kept or ():
            start[axis] = max(start[axis], int(np.ceil(-level.shift)))
        if (stop > start).all():
            yield start, stop - start


def _file(name, grouped, processes, process):
    stem = name if not grouped else "admbase-metric" if name[0] == "g" else "admbase-curv"
    return f"{stem}.xyz.h5" if processes == 1 else f"{stem}.xyz.file_{process}.h5"


def _metadata(file, parameters, processes):
    if "Parameters and Global Attributes" not in file:
        group = file.create_group("Parameters and Global Attributes")
        group.attrs["nioprocs"] = np.int32(processes)
        group.create_dataset(
            "All Parameters", data=np.bytes_(parameters or "ADMBase::metric_type = physical\n")
        )


def write_carpetx(
    folder, geometry, levels, iteration=0, time=0.0, names=(*METRIC, *CURVATURE), parameters=""
):
    """An openPMD file of one iteration as CarpetX writes it: axes z, y, x, no ghost zones."""
    import openpmd_api as openpmd

    folder.mkdir(parents=True, exist_ok=True)
    series = openpmd.Series(str(folder / f"run.it{iteration:08d}.bp4"), openpmd.Access.create)
    there = series.iterations[iteration]
    there.time = time
    there.set_attribute("AllParameters", parameters or "CarpetX::reflection_z = no\n")
    for number, level in enumerate(levels):
        components = list(level.components())
        fields = [sampled(geometry, level, start, tuple(shape), names) for start, shape in components]
        # A domain that is larger than the level.
        first = np.min([start for start, _ in components], axis=0) - 2
        last = np.max([start + shape for start, shape in components], axis=0) + 3
        for name in names:
            mesh = there.meshes[f"admbasex_{'metric' if name[0] == 'g' else 'curv'}_patch00_lev{number:02d}"]
            mesh.axis_labels = ["z", "y", "x"]
            mesh.grid_spacing = [level.spacing] * 3
            mesh.grid_global_offset = [level.spacing * float(i) for i in first[::-1]]
            record = mesh[f"admbasex_{name}"]
            record.position = [level.shift] * 3
            record.reset_dataset(openpmd.Dataset(np.dtype("float64"), list((last - first)[::-1])))
            for (start, _), values in zip(components, fields, strict=True):
                data = np.ascontiguousarray(values[name].T)
                record.store_chunk(data, list((start - first)[::-1]), list(data.shape))
                series.flush()
    series.close()
