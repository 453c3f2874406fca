"""Files of an evolution: horizons of AHFinderDirect and slices, of isotropic Schwarzschild that grows."""

import numpy as np

from horizon_texts import shape_text
from isoembed.relativity.spacetimes.schwarzschild import IsotropicSchwarzschild
from isoembed.relativity.spacetimes.slice_file import GAMMA
from slice_files import write_slice

STEPS = (0, 32, 64)
EDGE = np.linspace(-2.0, 2.0, 24)  # no point is the puncture


def mass(iteration):
    return 1.0 + iteration / 640


def time(iteration):
    return iteration / 128


def write_shapes(folder, series=("ah1",), steps=STEPS, table=True):
    """Shape files, and a table of their times as it is printed."""
    paths = []
    for name in series:
        for k in steps:
            paths.append(folder / f"h.t{k}.{name}.gp")
            paths[-1].write_text(shape_text(lambda u, k=k: 0.5 * mass(k) + 0.0 * u[:, 0], origin=np.zeros(3)))
        if table:
            rows = "".join(f"{k}\t{time(k):.3f}\t0.0\n" for k in steps)
            (folder / f"BH_diagnostics.{name}.gp").write_text(f"# column 1 = cctk_iteration\n{rows}")
    return paths


def write_slices(folder, pattern="gxx.{iteration}.npz", steps=STEPS):
    return [
        write_slice(
            folder / pattern.format(iteration=k, time=time(k)),
            IsotropicSchwarzschild(mass(k)),
            2.0,
            len(EDGE),
        )
        for k in steps
    ]


def write_evolution(path, steps=STEPS, iterations=False):
    """All slices in one HDF5 file."""
    import h5py

    x = np.stack(np.meshgrid(EDGE, EDGE, EDGE, indexing="ij"), axis=-1)
    with h5py.File(path, "w") as file:
        gamma = np.stack([IsotropicSchwarzschild(mass(k)).metric(x.reshape(-1, 3)) for k in steps])
        gamma = gamma.reshape(len(steps), *x.shape, 3)
        pairs = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
        for name, (i, j) in zip(GAMMA, pairs, strict=True):
            file[name] = gamma[..., i, j]
        file["origin"], file["spacing"] = x[0, 0, 0], EDGE[1] - EDGE[0]
        file["time"] = [time(k) for k in steps]
        if iterations:
            file["iteration"] = steps
