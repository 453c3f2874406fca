"""Deprecated attributes of `Embedding` and their replacements."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from isoembed.embedding.embedding import Embedding

ON_SURFACE = {
    **{
        name: name
        for name in (
            "bending_energy",
            "concave_edges",
            "fine_roughness",
            "inverted_vertices",
            "partially_inverted_vertices",
            "rough_edges",
            "roughness",
            "seams",
            "self_intersections",
        )
    },
    "face_polygons": "flat_faces.of_triangles",
    "face_sides": "flat_faces.sides",
    "polygon_edges": "flat_faces.edges",
}
"""Attributes of `Embedding.surface`, by their old names on `Embedding`."""

OF_SENSITIVITY = {
    "deviation",
    "deviation_bound",
    "given_jvp",
    "given_vjp",
    "integral_deviation",
    "jvp",
    "smallest_singular_value",
    "variation",
    "vjp",
}

FUNCTIONS = {
    "report": "isoembed.report(embedding)",
    "certificate": "isoembed.certify(embedding)",
    "comparison": "isoembed.compare(embedding, other)",
    "to_trimesh": "isoembed.io.to_trimesh(embedding)",
    "to_pyvista": "isoembed.io.to_pyvista(embedding)",
}
"""Functions of an embedding, by the names of old properties and methods."""


def moved(embedding: Embedding, name: str) -> Any:
    """Value of a deprecated attribute, with a `DeprecationWarning`.

    Raises
    ------
    AttributeError
        The name is unknown, or the property of this name raised the error.
    """
    if hasattr(type(embedding), name):
        return object.__getattribute__(embedding, name)  # raises the property's own error again
    if name in ON_SURFACE:
        place = f"embedding.surface.{ON_SURFACE[name]}"
    elif name in OF_SENSITIVITY:
        place = f"isoembed.Sensitivity(embedding).{name}"
    elif name in FUNCTIONS:
        place = FUNCTIONS[name]
    else:
        raise AttributeError(
            f"{type(embedding).__name__!r} object has no attribute {name!r}", name=name, obj=embedding
        )
    warnings.warn(
        f"embedding.{name} is {place} now; the old name goes with version 0.5",
        DeprecationWarning,
        stacklevel=3,
    )
    if name in ON_SURFACE:
        return attrgetter(ON_SURFACE[name])(embedding.surface)
    if name in OF_SENSITIVITY:
        from isoembed.embedding.sensitivity import Sensitivity

        return getattr(Sensitivity(embedding), name)
    if name == "certificate":
        return embedding._certificate
    from isoembed.embedding.comparison import compare
    from isoembed.embedding.report import report
    from isoembed.io.objects import to_pyvista, to_trimesh

    if name == "report":
        return report(embedding)
    methods: dict[str, Callable[..., Any]] = {
        "comparison": compare,
        "to_trimesh": to_trimesh,
        "to_pyvista": to_pyvista,
    }
    return partial(methods[name], embedding)
