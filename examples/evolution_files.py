"""Files as simulations write them: shapes of horizons, and slices on grids in three layouts.

- "files": slices/slice.<iteration>.h5, one slice each, in isoembed's own format;
- "axis": slices.h5, all slices in one file with an axis of time;
- "carpet": gxx.xyz.h5 ... kzz.xyz.h5 as Carpet writes them, with refinement levels.

Beside them are h.t<iteration>.<horizon>.gp and BH_diagnostics.<horizon>.gp as AHFinderDirect writes them.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from isoembed.relativity import StarSurface, ThreeGeometry

Floats = NDArray[np.float64]
LAYOUTS = ("files", "axis", "carpet")
PAIRS = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}
PATCHES = ("+z", "+x", "+y", "-x", "-y", "-z")


@dataclass(frozen=True)
class Box:
    """Points ``spacing * (i + 1/2)`` in a box: none of them has z = 0, where punctures are.

    Attributes
    ----------
    center : three floats
    half : float
        Half of each edge, about.
    spacing : float
    """

    center: Sequence[float]
    half: float
    spacing: float

    @property
    def first(self) -> NDArray[np.int64]:
        """The first index i along each axis."""
        return np.round((np.array(self.center) - self.half) / self.spacing).astype(np.int64)

    @property
    def origin(self) -> Floats:
        """The first point."""
        return self.spacing * (self.first + 0.5)

    @property
    def points(self) -> Floats:
        """All of them (n, n, n, 3)."""
        n = round(2.0 * self.half / self.spacing)
        axes = [start + self.spacing * np.arange(n) for start in self.origin]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@dataclass(frozen=True)
class Evolution:
    """A folder of files of an evolution.

    Attributes
    ----------
    folder : Path
    layout : str
        One of `LAYOUTS`.
    """

    folder: Path
    layout: str

    def add(
        self,
        iteration: int,
        time: float,
        geometry: ThreeGeometry,
        levels: Sequence[Sequence[Box]],
    ) -> None:
        """Write a slice.

        Parameters
        ----------
        iteration : int
        time : float
        geometry : ThreeGeometry
        levels : sequence of sequences of Box
            Refinement levels, the coarsest first; without levels in the layout the coarsest is written.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        if self.layout == "carpet":
            for level, boxes in enumerate(levels):
                for component, box in enumerate(boxes):
                    place = f"it={iteration} tl=0 rl={level} c={component}"
                    self._add_component(place, time, box, geometry)
            return
        ((box,), *_) = levels
        fields = dict(_sampled(geometry, box, geometry.time_symmetric))
        fields |= {"origin": box.origin, "spacing": np.full(3, box.spacing)}
        fields |= {"time": np.array(time), "iteration": np.array(iteration)}
        if self.layout == "files":
            (self.folder / "slices").mkdir(exist_ok=True)
            _write(self.folder / "slices" / f"slice.{iteration}.h5", fields)
        else:
            _append(self.folder / "slices.h5", fields)

    def add_horizon(self, name: str, iteration: int, time: float, surface: StarSurface) -> None:
        """Write the shape of a horizon, and a line of its diagnostics."""
        path = self.folder / f"h.t{iteration}.{name}.gp"
        path.write_text(_shape_text(surface), encoding="utf-8")
        diagnostics = self.folder / f"BH_diagnostics.{name}.gp"
        if not diagnostics.exists():
            diagnostics.write_text("# column 1 = cctk_iteration\n# column 2 = cctk_time\n", encoding="utf-8")
        with diagnostics.open("a", encoding="utf-8") as file:
            file.write(f"{iteration}\t{time:.9g}\n")

    def _add_component(self, place: str, time: float, box: Box, geometry: ThreeGeometry) -> None:
        import h5py

        for name, values in _sampled(geometry, box, time_symmetric=False):
            with h5py.File(self.folder / f"{name}.xyz.h5", "a") as file:
                # Fortran's order: x is the last index of the array in the file.
                stored = file.create_dataset(f"ADMBASE::{name} {place}", data=values.T, compression="gzip")
                stored.attrs["origin"], stored.attrs["delta"] = box.origin, np.full(3, box.spacing)
                stored.attrs["iorigin"], stored.attrs["time"] = box.first.astype(np.int32), time
                stored.attrs["cctk_nghostzones"] = np.zeros(3, dtype=np.int32)


def _sampled(geometry: ThreeGeometry, box: Box, time_symmetric: bool) -> Iterator[tuple[str, Floats]]:
    """Fields (n, n, n) by their names."""
    points = box.points
    x = points.reshape(-1, 3)
    parts = {"g": geometry.metric}
    if not time_symmetric:
        parts["k"] = geometry.extrinsic_curvature
    for letter, function in parts.items():
        values = function(x)
        for name, (i, j) in PAIRS.items():
            yield letter + name, np.ascontiguousarray(values[:, i, j].reshape(points.shape[:3]))


def _write(path: Path, arrays: dict[str, Floats]) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file.create_dataset(name, data=values, compression="gzip" if values.ndim == 3 else None)


def _append(path: Path, arrays: dict[str, Floats]) -> None:
    """Add a moment: all arrays have an axis of time in front, which grows."""
    import h5py

    with h5py.File(path, "a") as file:
        for name, values in arrays.items():
            if name not in file:
                shape, chunks = (0, *values.shape), (1, *values.shape)
                file.create_dataset(name, shape, values.dtype, maxshape=(None, *values.shape), chunks=chunks)
            stored = file[name]
            stored.resize(len(stored) + 1, axis=0)
            stored[-1] = values


def _shape_text(surface: StarSurface, points: int = 25) -> str:
    """A shape file of AHFinderDirect: the radius on six patches of an inflated cube."""
    angles = np.linspace(-45.0, 45.0, points)
    slopes = np.tan(np.radians(angles))
    lines = [f"# N_patches = {len(PATCHES)}", "# origin = " + " ".join(f"{x:.16g}" for x in surface.center)]
    for patch in PATCHES:
        axis = "xyz".index(patch[1])
        others = [k for k in range(3) if k != axis]
        u = np.empty((points, points, 3))
        u[..., axis] = 1.0 if patch[0] == "+" else -1.0
        u[..., others[0]], u[..., others[1]] = slopes[None, :], slopes[:, None]
        u /= np.linalg.norm(u, axis=2, keepdims=True)
        x = surface.points(u.reshape(-1, 3))
        r = np.linalg.norm(x - np.array(surface.center), axis=1)
        lines += ["", f"### {patch} patch", f"# N_rho = {points}", f"# N_sigma = {points}"]
        lines += ["# dpx = dsigma", "# dpy = drho", "# dpx dpy gridfn x y z"]
        for k, row in enumerate(np.column_stack([r, x])):
            if k % points == 0:
                lines.append("")
            numbers = (angles[k % points], angles[k // points], *row)
            lines.append("\t".join(f"{number:.15g}" for number in numbers))
    return "\n".join([*lines, ""])


def written_by_command(description, write):
    """Write an evolution as the command line says: its folder, how many moments, and the layout."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("--moments", type=int, default=17, metavar="N")
    parser.add_argument("--layout", choices=LAYOUTS, default="files")
    options = parser.parse_args()
    if Path(options.folder).exists():
        parser.error(f"{options.folder} is there already")
    write(options.folder, options.moments, options.layout)
