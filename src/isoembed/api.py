"""`embed`, `glue` and `unfold`: the functions that users call, with paths, meshes and objects as input."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.method import TOLERANCE, Method, solve
from isoembed.methods import as_method, method_class
from isoembed.metric.glued import GluedMetric
from isoembed.metric.other_packages import of_pyvista, of_trimesh
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.checkpoints import Checkpoint
from isoembed.progress.stages import Listener
from isoembed.space.models import Model

if TYPE_CHECKING:
    from isoembed.gluing import Net, Unfolding
    from isoembed.gluing.edge_choice import Edges
    from isoembed.gluing.sheet_search import Objective

# Files and nets are imported where there are some: to embed a metric takes neither.


def embed(
    metric: PolyhedralMetric | GluedMetric | str | os.PathLike[str] | Any,
    *,
    method: str | Method | None = None,
    tolerance: float = TOLERANCE,
    length_errors: ArrayLike | None = None,
    boundary: ArrayLike | str | None = None,
    start: ArrayLike | None = None,
    progress: Listener | None = None,
    resume: Checkpoint | None = None,
) -> Embedding:
    """Find the surface that realizes a polyhedral metric, in the space whose curvature its triangles have.

    Parameters
    ----------
    metric : PolyhedralMetric, GluedMetric, path, or a mesh
        The metric, or a file or mesh to take it from.  A flat metric, which is the default, gives a surface
        in R^3.  A path is that of a metric, a mesh or a net.  From a mesh, which is a tuple
        (vertices, faces), a ``trimesh.Trimesh``, a ``pyvista.PolyData`` or a surface of this package, only
        the lengths are taken.  A triangulation by `isoembed.smooth.triangulate_metric` has its own metric.
    method : {"aim", "paper", "alexandrov", "sheet"}, the name of an installed method, or a Method, optional
        ``"aim"`` is `isoembed.Aim`, the default; ``"paper"`` is `isoembed.Paper`, AIM as printed.  Both keep
        the given triangles.  ``"alexandrov"`` is `isoembed.Alexandrov`, the exact convex polyhedron of a
        convex metric, on triangles of its own; it is the default for a `GluedMetric`, which needs it.  A net
        is by default folded as `isoembed.gluing.embed_net` does.  ``"sheet"`` is `isoembed.Sheet`,
        for which `boundary` stands.  Pass an `Aim`, a `Paper`, an `Alexandrov`, a `Sheet` or a `Method` of
        your own to set parameters.
    tolerance : float
        Largest ``| |x_a - x_b| - l_ab |`` over the mean edge length; in curved space, of distances there.
    length_errors : float or array_like, shape (E,), optional
        Standard deviations of the lengths, whose errors are independent, in their unit: one for all, or one
        for each edge.  The surface then is a `MeasuredSurface`, a smooth one whose lengths agree with these
        within the errors; converged then means that it passes a chi-square test.  The polyhedron of
        ``"alexandrov"`` has the lengths exactly, and faces that are flat within the errors.  Errors of zero
        take the lengths as exact, even if their digits show that they were rounded.
    boundary : {"free", "plane"} or array_like, shape (B,) or (B, 3), optional
        Condition at the boundary of a surface with boundary or of higher genus, instead of a method:
        ``"free"`` for one of least bending, ``"plane"`` for the convex cap, heights or positions of the
        boundary; see `isoembed.Sheet`.  The surface then is a `SheetEmbedding`.
    start : array_like, shape (V, 3), optional
        A surface to start from, with `boundary`.
    progress : callable, optional
        Called with an `isoembed.progress.stages.Progress`, which includes the latest checkpoint.  An
        exception raised by it stops the computation; `KeyboardInterrupt` has the effect of Ctrl-C.
    resume : Checkpoint, optional
        Where an interrupted run with the same metric, method and tolerance is to go on.

    Returns
    -------
    Embedding
        Its residual, measured on the vertices that it holds, is within the tolerance.  With
        ``Aim(best_fit=True)`` it may be a `FittedSurface` instead, whose status is ``"best fit"``.

    Raises
    ------
    FileError
        The file cannot be read.
    InvalidMetric
        The method is ``"alexandrov"`` and the metric is not convex; the message names the vertex.
    NotEmbedded
        No such surface was found; the exception holds the best attempt.
    InvalidParameter
        The method is unknown or does not take errors of lengths, the tolerance is not positive, a parameter
        does not fit the metric, or the checkpoint belongs to another computation.
    Interrupted
        On Ctrl-C; a `KeyboardInterrupt` that holds the checkpoint to go on from.

    Examples
    --------
    >>> tetrahedron = PolyhedralMetric([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [1.0] * 6)
    >>> round(embed(tetrahedron).volume, 12)  # sqrt(2) / 12
    0.117851130198
    """
    source = _metric(metric)
    how: dict[str, Any] = {"tolerance": tolerance, "progress": progress, "resume": resume}
    if boundary is not None:
        if method is not None:
            raise InvalidParameter("give either boundary or method, not both")
        kind: Any = method_class("sheet")
        own = source.simplicial() if isinstance(source, GluedMetric) else source
        return solve(own, kind(boundary, start), length_errors=length_errors, **how)
    if start is not None:
        raise InvalidParameter(
            "a start is for surfaces with boundary or of higher genus: give boundary='free'"
        )
    if method is None and isinstance(source, GluedMetric):
        from isoembed.gluing import Net, embed_net

        if isinstance(source, Net) and length_errors is None:
            return embed_net(source, **how)
        method = "alexandrov"
    return solve(source, as_method(method or "aim"), length_errors=length_errors, **how)


def glue(
    polygons: Sequence[ArrayLike] | Unfolding | str | os.PathLike[str],
    sides: Sequence[Any] | None = None,
    *,
    corners: Sequence[Sequence[str | int]] | None = None,
    tolerance: float | None = None,
    curvature: float = 0.0,
    model: Model = "ambient",
    any_surface: bool = False,
) -> Net:
    """Glue the sides of polygons, of a file or of an unfolded surface, to a metric: `embed` finds the solid.

    Parameters
    ----------
    polygons : sequence of array_like, Unfolding, or path
        The corners of each polygon; or the result of `unfold`; or a file as of `isoembed.io.net.read_net`.
    sides, corners, curvature, model, any_surface
        Of polygons, as of `isoembed.gluing.glue`: the glued sides, or the names of the corners, and whether
        the other sides form a boundary.  Files contain these.
    tolerance : float, optional
        As of `isoembed.gluing.glue`, of polygons and files.

    Returns
    -------
    Net

    Raises
    ------
    FileError
        The file cannot be read.
    InvalidMetric, InvalidParameter
        As `isoembed.gluing.glue`.

    Examples
    --------
    A tetrahedron from the names of the corners of four triangles:

    >>> from isoembed.gluing import regular_polygon
    >>> net = glue([regular_polygon(3)] * 4, corners=["abc", "abd", "acd", "bcd"])
    >>> round(embed(net).volume, 12)  # sqrt(2) / 12
    0.117851130198
    """
    from isoembed.gluing import Unfolding
    from isoembed.gluing import glue as glue_polygons

    if isinstance(polygons, str | os.PathLike | Unfolding):
        options = {"sides": sides, "corners": corners, "curvature": curvature or None}
        options["any_surface"] = any_surface or None
        for name, value in options.items():
            if value is not None:
                raise InvalidParameter(
                    f"{name} can be given only with arrays of corners; a file or an unfolding has its own"
                )
    if isinstance(polygons, Unfolding):
        return polygons.net
    if isinstance(polygons, str | os.PathLike):
        from isoembed.io.net import read_net

        return read_net(polygons, tolerance=tolerance)
    surface: dict[str, Any] = {"curvature": curvature, "model": model, "any_surface": any_surface}
    return glue_polygons(polygons, sides, corners=corners, tolerance=tolerance, **surface)


def unfold(
    surface: Embedding | str | os.PathLike[str] | Any,
    *,
    cut: Edges = (),
    keep: Edges = (),
    objective: Objective = "sheets",
    within: tuple[float, float] | None = None,
) -> Unfolding:
    """Cut a surface along edges and unfold it into the plane, in one sheet if such a net is found.

    Parameters
    ----------
    surface : Embedding, path, or a mesh
        In R^3: a result of `embed`, a file with vertices, or a mesh as of `embed`.  Its vertices are used,
        not its metric.  For the cuts see `isoembed.gluing.unfold`.
    cut, keep, objective, within
        As of `isoembed.gluing.unfold`: edges, by their vertices, to cut or to keep; the objective of the
        net; a rectangle that contains each sheet.

    Returns
    -------
    Unfolding
        ``unfold(surface).save("net.svg")`` writes it.

    Raises
    ------
    FileError
        The file cannot be read, or is a metric without vertices.
    InvalidMetric, InvalidParameter
        As `isoembed.gluing.unfold`.

    Examples
    --------
    >>> unfold(([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    Unfolding(1 sheet, 3 pairs of sides, 3 folds)
    """
    from isoembed.gluing import unfold as unfold_surface
    from isoembed.io.surface import read_surface, surface_of

    if isinstance(surface, PolyhedralMetric | GluedMetric):
        raise InvalidParameter("the surface is a metric: embed it first, unfold(embed(metric))")
    if isinstance(surface, str | os.PathLike):
        surface = read_surface(surface)
    elif not isinstance(surface, Embedding):
        surface = surface_of(_mesh(surface, "surface"), "the mesh")
    return unfold_surface(surface, cut=cut, keep=keep, objective=objective, within=within)


def _metric(source: Any) -> PolyhedralMetric | GluedMetric:
    """The metric itself, or that of a file or a mesh.

    Raises
    ------
    FileError, InvalidMetric, InvalidParameter
        There is none.
    """
    if isinstance(source, PolyhedralMetric | GluedMetric):
        return source
    if isinstance(source, str | os.PathLike):
        from isoembed.io.metric import read_metric
        from isoembed.io.net import holds_net, read_net

        return read_net(source) if holds_net(source) else read_metric(source, any_surface=True)
    if isinstance(source_metric := getattr(source, "metric", None), PolyhedralMetric) and not hasattr(
        source, "vertices"
    ):
        return source_metric  # of a triangulation by `isoembed.smooth.triangulate_metric`
    return PolyhedralMetric.from_mesh(**_mesh(source, "metric"))


def _mesh(source: Any, wanted: str) -> dict[str, Any]:
    """Arguments of `PolyhedralMetric.from_mesh` for a mesh.

    Raises
    ------
    InvalidParameter
        The object is not a mesh.
    """
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return of_trimesh(source)
    if hasattr(source, "points") and hasattr(source, "faces"):
        return of_pyvista(source)
    if isinstance(source, tuple | list) and len(source) == 2:
        return dict(zip(("vertices", "faces"), source, strict=True))
    instead = "PolyhedralMetric(faces, lengths, edges), " if wanted == "metric" else ""
    raise InvalidParameter(
        f"the {wanted} is a {type(source).__name__}: give {instead}the path of a file, or a mesh, such as "
        "(vertices, faces)"
    )
