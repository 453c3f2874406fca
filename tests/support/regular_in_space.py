"""Regular solids of hyperbolic and spherical space in closed form, from their dihedral angles.

At a vertex of {p, q} the faces cut a small sphere in a regular q-gon with sides alpha, the angles of the
faces, and with the dihedral angles delta: ``sin(delta / 2) cos(alpha / 2) = cos(pi / q)``.  In a face
``cs(l / 2) sin(alpha / 2) = cos(pi / p)`` with the edge l.
"""

from dataclasses import dataclass

import numpy as np

from isoembed.space import Space
from solids import polygons, uniform

SYMBOLS = {
    "tetrahedron": (3, 3),
    "cube": (4, 3),
    "octahedron": (3, 4),
    "dodecahedron": (5, 3),
    "icosahedron": (3, 5),
}


@dataclass(frozen=True)
class RegularSolid:
    """A regular solid: ambient points, the vertices around each face, and what is known of it.

    The angles are those of faces at their corners, and those between faces.
    """

    points: np.ndarray
    faces: list
    edge: float
    face_angle: float
    dihedral: float
    deficit: float
    area: float
    radius: float


def regular_solid(name, curvature, dihedral):
    """The regular solid with this dihedral angle, which together with the curvature tells its size.

    The angle is below that of the Euclidean solid in hyperbolic space and above it on the sphere.
    """
    p, q = SYMBOLS[name]
    space = Space(curvature)
    face_angle = 2 * np.arccos(np.cos(np.pi / q) / np.sin(dihedral / 2))
    cosine = np.cos(np.pi / p) / np.sin(face_angle / 2)
    edge = 2 * space.radius * (np.arccosh(cosine) if curvature < 0 else np.arccos(cosine))
    x = uniform(name)
    faces = [face.tolist() for face in polygons(x)]
    radius = space.asn(space.chord(edge) / 2 * 2 * np.linalg.norm(x[0]))  # the edges of x are 1
    return RegularSolid(
        points=space.sn(radius) * x / np.linalg.norm(x, axis=1)[:, None],
        faces=faces,
        edge=float(edge),
        face_angle=float(face_angle),
        dihedral=dihedral,
        deficit=float(2 * np.pi - q * face_angle),
        area=float(len(faces) * (p * face_angle - (p - 2) * np.pi) / curvature),
        radius=float(radius),
    )


SOLIDS = (
    ("dodecahedron", -1.0, np.pi / 2),
    ("cube", -0.25, 2 * np.pi / 5),
    ("icosahedron", -4.0, 2 * np.pi / 3),
    ("tetrahedron", -1.0, np.radians(62.0)),
    ("octahedron", -1.0, np.radians(95.0)),
    ("tetrahedron", 1.0, 2 * np.pi / 5),
    ("tetrahedron", 0.5, np.pi / 2),
    ("octahedron", 2.0, 2 * np.pi / 3),
    ("dodecahedron", 1.0, 2 * np.pi / 3),
    ("cube", 1.0, 2 * np.pi / 3),
)
"""Names, curvatures and dihedral angles."""

CELLS = (
    (*SOLIDS[5], 2 * np.pi**2 / 600),
    (*SOLIDS[6], 2 * np.pi**2 / 16),
    (*SOLIDS[7], 2 * np.pi**2 / 24),
    (*SOLIDS[8], 2 * np.pi**2 / 120),
    (*SOLIDS[9], 2 * np.pi**2 / 8),
    (*SOLIDS[0], 120 * 0.0358850633),
    (*SOLIDS[1], 48 * 0.0358850633),
    (*SOLIDS[2], 120 * 0.0390502856),
)
"""Those that tessellate their space, with their volumes in cubed radii of curvature.

The 3-sphere of volume 2 pi^2 is cut into all cells of a regular polytope of R^4.  The others consist of as
many hyperbolic simplices as the solid has symmetries, of the Coxeter groups [5, 3, 4] and [3, 5, 3] (Johnson,
Kellerhals, Ratcliffe and Tschantz, The size of a hyperbolic Coxeter simplex, Transformation Groups 4, 1999).
"""
