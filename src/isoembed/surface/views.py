"""What a surface is shown as, and turned into, by rooms above this one and by other packages."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyvista
    import trimesh
    from matplotlib.figure import Figure

MAKERS = {
    "plot": "isoembed.plot.picture:figure",
    "page": "isoembed.plot.notebook:notebook_html",
    "trimesh": "isoembed.io.objects:to_trimesh",
    "pyvista": "isoembed.io.objects:to_pyvista",
}
"""Where the functions are that make them; they are imported on first use."""


class Views:
    """What an `Embedding` is shown as."""

    def _made(self, name: str, **options: Any) -> Any:
        return EntryPoint(name, MAKERS[name], "isoembed.views").load()(self, **options)

    def plot(self, **options: Any) -> Figure:
        """Draw the surface; a notebook shows the picture.

        Parameters
        ----------
        **options
            ``color`` and ``caption``, as of `isoembed.plot.figure`.

        Returns
        -------
        matplotlib.figure.Figure
            To save: ``surface.plot().savefig("surface.pdf")``.

        Raises
        ------
        FileError
            matplotlib is not installed: ``pip install 'isoembed[plot]'``.
        InvalidParameter
            There is no such quantity to color it by.
        """
        return self._made("plot", **options)

    def to_trimesh(self) -> trimesh.Trimesh:
        """The surface as an object of trimesh, with the same vertices and triangles.

        Returns
        -------
        trimesh.Trimesh
            With ``mean_curvature`` and ``residual`` (V,) among its ``vertex_attributes``.  Of hyperbolic and
            spherical space its vertices are conformal coordinates, and its ``metadata`` has the
            ``curvature``.

        Raises
        ------
        ImportError
            trimesh is not installed: ``pip install 'isoembed[trimesh]'``.
        """
        return self._made("trimesh")

    def to_pyvista(self) -> pyvista.PolyData:
        """The surface as an object of PyVista: ``surface.to_pyvista().plot(scalars="mean_curvature")``.

        Returns
        -------
        pyvista.PolyData
            With ``mean_curvature`` and ``residual`` (V,) among its ``point_data``.  The faces of a
            `ConvexPolyhedron` are polygons, but for those with flat vertices inside.  Of hyperbolic and
            spherical space its points are conformal coordinates, and its ``field_data`` has the
            ``curvature``.

        Raises
        ------
        ImportError
            PyVista is not installed: ``pip install 'isoembed[pyvista]'``.
        """
        return self._made("pyvista")

    def _repr_html_(self) -> str | None:
        """What notebooks show: see `isoembed.plot.notebook`."""
        return self._made("page")
