"""Files of slices on Cartesian grids, written from closed forms."""

import numpy as np

NAMES = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}


def write_slice(path, geometry, half, points, center=(0.0, 0.0, 0.0)):
    """A slice on a cube of `points`^3 points, from -`half` to `half` about the center."""
    edge = np.linspace(-half, half, points)
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1) + np.array(center)
    shape, x = x.shape[:3], x.reshape(-1, 3)
    tables = {f"g{name}": geometry.metric(x)[:, i, j].reshape(shape) for name, (i, j) in NAMES.items()}
    if not geometry.time_symmetric:
        K = geometry.extrinsic_curvature(x)
        tables |= {f"k{name}": K[:, i, j].reshape(shape) for name, (i, j) in NAMES.items()}
    np.savez(path, origin=x[0], spacing=edge[1] - edge[0], **tables)
