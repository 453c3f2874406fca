"""Whether a surface is the convex polyhedron of a metric: a check that shares no code with the solver.

It takes a `Case` and what was returned, and measures with numpy and scipy alone, all lengths over the
diameter.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

ALLOWED = {"lengths": 1e-10, "paths": 3e-10, "off hull": 1e-9, "area": 1e-9, "volume": 1e-9, "deficits": 1.0}
"""The first two over the mean edge length; the last over what lengths off by as much would do."""

DISTANCE = 1e-9  # of the diameter, where the lengths determine the vertices
FLAT = 1e-9  # of the diameter: thickness of a body that is flat


def check(case, found):
    """Everything by which a surface may be wrong: a dictionary with the keys of `ALLOWED`.

    Parameters
    ----------
    case : Case
    found : ConvexPolyhedron
    """
    vertices, faces = np.asarray(found.vertices), np.asarray(found.faces)
    given = np.asarray(found.given.face_lengths) if case.repair else case.lengths
    unit = np.linalg.norm(vertices - vertices.mean(axis=0), axis=1).max() * 2
    vertices, lengths = (vertices - vertices.mean(axis=0)) / unit, given / unit
    assert is_sphere(faces, len(vertices))
    halfedges = sides_of(case)
    mean = lengths.ravel()[halfedges].mean()
    own = np.linalg.norm(vertices[np.roll(faces, -1, axis=1)] - vertices[faces], axis=2)
    claimed = {
        tuple(e): l / unit for e, l in zip(found.metric.edges.tolist(), found.metric.lengths, strict=True)
    }
    claims = np.array(
        [[claimed[min(f[k], f[k - 2]), max(f[k], f[k - 2])] for k in range(3)] for f in faces.tolist()]
    )
    paths = found.edge_paths.points(vertices)
    starts = np.asarray(found.edge_paths.point_offsets)[:-1]
    stops = np.append(starts[1:], len(paths)) - 1
    ends = np.stack([case.faces.ravel(), np.roll(case.faces, -1, axis=1).ravel()], axis=1)[halfedges]
    steps = np.linalg.norm(np.diff(paths, axis=0), axis=1)
    steps[stops[:-1]] = 0.0
    middles = (paths[1:] + paths[:-1])[np.delete(np.arange(len(paths) - 1), stops[:-1])] / 2
    missed = np.abs(np.add.reduceat(np.append(steps, 0.0), starts) - lengths.ravel()[halfedges])
    missed += np.minimum(*(
        np.linalg.norm(paths[starts] - vertices[ends[:, k]], axis=1)
        + np.linalg.norm(paths[stops] - vertices[ends[:, 1 - k]], axis=1)
        for k in range(2)
    ))  # fmt: skip
    hull = Hull(vertices)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    given_deficits, slack = deficits(case.faces, lengths)
    deficit_of_own, own_slack = deficits(faces, own)
    tolerance = ALLOWED["lengths"] * mean * (slack + own_slack) + 1e-12
    return {
        "lengths": float(np.abs(own - claims).max() / mean),
        "paths": float(missed.max() / mean),
        "off hull": float(hull.distances(np.vstack([paths, middles])).max()),
        # Rounding of the lengths alone changes areas of slivers by more than 1e-9 of themselves.
        "area": float(max(abs(area - hull.area) / area, abs(area - heron(lengths).sum()))),
        "volume": float(abs(volume - hull.volume) / area),
        "deficits": float((np.abs(given_deficits - deficit_of_own) / tolerance).max()),
    }


def is_sphere(faces, n):
    """Whether these are triangles of a sphere through n vertices."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    back = np.unique(sides[:, ::-1], axis=0)
    closed = np.array_equal(np.unique(sides, axis=0), back) and len(back) == len(sides) == 6 * n - 12
    return closed and np.array_equal(np.unique(faces), np.arange(n))


def sides_of(case):
    """One half-edge of each given edge, in the order of `ConvexPolyhedron.edge_paths`."""
    if case.twins is not None:
        return np.flatnonzero(np.arange(case.twins.size) < case.twins)
    start, end = case.faces.ravel(), np.roll(case.faces, -1, axis=1).ravel()
    forward = np.flatnonzero(start < end)
    return forward[np.lexsort((end[forward], start[forward]))]


class Hull:
    """The convex hull of points, which may lie in a plane."""

    def __init__(self, points):
        try:
            hull = ConvexHull(points)
            self.area, self.volume, self.equations = hull.area, hull.volume, hull.equations
        except QhullError:
            _, size, axes = np.linalg.svd(points, full_matrices=False)
            if size[2] > FLAT:
                raise
            hull = ConvexHull(points @ axes[:2].T)
            normal = axes[2]
            walls = np.column_stack([hull.equations[:, :2] @ axes[:2], hull.equations[:, 2]])
            self.area, self.volume = 2 * hull.volume, 0.0
            self.equations = np.vstack([walls, [*normal, 0.0], [*-normal, 0.0]])

    def distances(self, points):
        """How far points are from the surface of the hull, measured to the plane of a face."""
        return np.abs((points @ self.equations[:, :3].T + self.equations[:, 3]).max(axis=1))


def heron(lengths):
    """Areas of triangles."""
    a, b, c = np.sort(lengths.astype(np.longdouble), axis=1).T[::-1]
    return np.sqrt(np.maximum((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)), 0)) / 4


def deficits(faces, lengths):
    """Deficits in extended precision, and by how much they change per unit of error of the lengths, (V,)."""
    l = lengths.astype(np.longdouble)
    a, b, c = l.T  # from corner 0 to 1, 1 to 2, 2 to 0
    area = heron(lengths)
    angles = np.stack(
        [np.arctan2(4 * area, p * p + q * q - r * r) for p, q, r in ((a, c, b), (a, b, c), (b, c, a))]
    )
    with np.errstate(divide="ignore"):
        slack = 3 * l.max(axis=1) / (2 * area)
    corners, n = faces.ravel(), faces.max() + 1
    total = np.zeros(n, dtype=np.longdouble)
    np.add.at(total, corners, angles.T.ravel())
    return 2 * np.pi - total.astype(float), np.bincount(corners, np.repeat(slack.astype(float), 3))


def distance(found, true):
    """Largest distance after the best rigid motion, mirror images allowed, over the diameter."""
    size = np.abs(true - true.mean(axis=0)).max()
    a, b = (x / size - (x / size).mean(axis=0) for x in (found, true))
    u, _, v = np.linalg.svd(a.T @ b)
    return float(np.linalg.norm(a @ u @ v - b, axis=1).max() / (2 * np.linalg.norm(b, axis=1).max()))


def uncertainty(case, found, residual=0.0):
    """How far the errors of the lengths may move a vertex, to first order, over the diameter.

    Those of rounding, or what an answer misses lengths by.  Root mean square of independent errors, at the
    body that the lengths came from or at the one that was found, where they move it farther; infinite where a
    body is flat or unknown.  A vertex in a face whose angles, by rounding, add up to a little less than 2 pi
    is a corner, above that face by the root of what is missing.  The rigidity matrix of the body without that
    vertex does not know of it, but that of what was found does; and the first knows a corner that was taken
    for flat.
    """
    if case.core is None:
        return np.inf
    least = sensitivity(*case.core)
    core = getattr(found, "core", None)
    if core is not None:
        tables, vertices = core
        least = max(least, sensitivity(vertices, tables.faces))
    return float(max(case.roundings * np.finfo(float).eps, residual) * least)


def sensitivity(points, faces):
    """By how much of the diameter independent relative errors of the lengths, of size 1, move a vertex."""
    points = (points - points.mean(axis=0)) / (2 * np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    edges = np.unique(
        np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1), axis=0
    )
    arms = points[edges[:, 0]] - points[edges[:, 1]]
    lengths = np.linalg.norm(arms, axis=1)
    columns = np.zeros((len(points), 3, len(edges)))
    i = np.arange(len(edges))
    columns[edges[:, 0], :, i], columns[edges[:, 1], :, i] = arms / lengths[:, None], -arms / lengths[:, None]
    q, r = np.linalg.qr(columns.reshape(-1, len(edges)))
    try:
        moves = (q @ np.linalg.inv(r).T) * lengths  # the pseudoinverse of the rows
    except np.linalg.LinAlgError:
        return np.inf
    return np.sqrt((moves**2).sum(axis=1).max())
