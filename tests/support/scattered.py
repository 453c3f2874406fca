"""Scattered points of closed surfaces, and HDF5 files of arrays."""

import numpy as np

from isoembed.mesh.triangulation import Triangulation


def lattice(n, seed=0):
    """Directions all over the sphere, in no order."""
    k = np.random.default_rng(seed).permutation(n)
    z, phi = 1.0 - (2.0 * k + 1.0) / n, k * np.pi * (3.0 - np.sqrt(5.0))
    s = np.sqrt(1.0 - z**2)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)


def bumpy(u):
    return u * (1.0 + 0.3 * u[:, :1] * u[:, 1:2] + 0.2 * u[:, 2:])


def is_closed_and_outward(points, faces, center):
    assert Triangulation(faces).n_vertices == len(points)
    a, b, c = (points - center)[faces.T]
    return bool(np.all(np.einsum("fi,fi->f", a, np.cross(b, c)) > 0))


def write_hdf5(path, arrays, group="/"):
    import h5py

    with h5py.File(path, "a") as file:
        place = file.require_group(group)
        for name, values in arrays.items():
            place[name] = values
    return path
