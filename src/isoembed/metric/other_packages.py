"""Arrays of trimesh and PyVista meshes from their attributes, without importing these packages."""

from typing import Any

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.mesh.polygons import polygons_of_cells


def of_trimesh(mesh: Any) -> dict[str, Any]:
    """Arguments of `PolyhedralMetric.from_mesh` for a ``trimesh.Trimesh``.

    Raises
    ------
    InvalidParameter
        The object has no vertices and faces.
    """
    _check(mesh, ("vertices", "faces"), "a trimesh.Trimesh has; of a Scene give one mesh")
    return {
        "vertices": np.asarray(mesh.vertices),
        "faces": np.asarray(mesh.faces),
        **_space(getattr(mesh, "metadata", {})),
    }


def of_pyvista(mesh: Any) -> dict[str, Any]:
    """Arguments of `PolyhedralMetric.from_mesh` for a ``pyvista.PolyData``.

    Raises
    ------
    InvalidParameter
        The object has no points and faces.
    """
    _check(mesh, ("points", "faces"), "a pyvista.PolyData has; of other datasets give the extract_surface()")
    if len(getattr(mesh, "strips", ())):
        mesh = mesh.triangulate()
    return {
        "vertices": np.asarray(mesh.points),
        "faces": polygons_of_cells(np.asarray(mesh.faces)),
        **_space(getattr(mesh, "field_data", {})),
    }


def _check(mesh: Any, names: tuple[str, str], who: str) -> None:
    missing = [name for name in names if not hasattr(mesh, name)]
    if missing:
        raise InvalidParameter(f"an object of type {type(mesh).__name__} has no {missing[0]}, as {who}")


def _space(data: Any) -> dict[str, Any]:
    """Ambient space as recorded by `isoembed.io.to_trimesh` and `isoembed.io.to_pyvista`."""
    if "curvature" not in data:
        return {}
    return {"curvature": float(np.ravel(data["curvature"])[0]), "model": "conformal"}
