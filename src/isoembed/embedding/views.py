"""What a surface is shown as, saved as, and turned into, by rooms above this one and by other packages.

Methods are where users look for these, and what they return is made above.  So this module imports upward, at
the call, and the contract in pyproject.toml names each import.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    import pyvista
    import trimesh
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from isoembed.embedding.embedding import Embedding
    from isoembed.plot.coloring import Quantity


class Views:
    """What an `Embedding` is shown as."""

    @property
    def _surface(self) -> Embedding:
        return cast("Embedding", self)

    def save(self, path: str | os.PathLike[str], *, color: str | Quantity | None = None) -> None:
        """Write the surface, by the ending of the file: as a mesh, a picture or a page for the browser.

        Parameters
        ----------
        path : path
            ``.ply``, ``.obj``, ``.stl``, ``.off``, ``.npz``, ``.json``, ``.fold``, ``.vtk``, ``.vtu``,
            or ``.vtp`` for the surface, as `isoembed.io.write_surface` writes it;
            ``.png``, ``.svg`` or ``.pdf`` for a picture; ``.html`` for a page.
        color : str or Quantity, optional
            Of a picture: what the colors show, one of `isoembed.plot.QUANTITIES`.

        Raises
        ------
        FileError
            The ending is not known, the file cannot be written, or for a picture matplotlib is not installed:
            ``pip install 'isoembed[plot]'``.
        InvalidParameter
            There is no such quantity, or the file has no colors.
        """
        from isoembed.plot.saving import save_surface

        save_surface(self._surface, path, color=color)

    def plot(
        self, *, color: str | Quantity = "mean curvature", caption: str = "", ax: Axes | None = None
    ) -> Figure:
        """Draw the surface; a notebook shows the picture, with pyplot and without.

        Parameters
        ----------
        color : str or Quantity
            What the colors show: ``"mean curvature"``, ``"Gaussian curvature"``, ``"residual"``,
            ``"concave edges"``, ``"conformal factor"``, ``"sides"``, or a quantity of one's own.
        caption : str
            By default the number of vertices, int H dA and the residual.
        ax : matplotlib.axes.Axes, optional
            Where to draw, with a color bar beside it and the caption, if there is one, as the title.

        Returns
        -------
        matplotlib.figure.Figure
            That of `ax`, or a new one.  To save: ``surface.save("surface.pdf")``, or its ``savefig``.

        Raises
        ------
        FileError
            matplotlib is not installed: ``pip install 'isoembed[plot]'``.
        InvalidParameter
            There is no such quantity to color it by.
        """
        from isoembed.plot.picture import figure

        return figure(self._surface, color=color, caption=caption, ax=ax)

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
        from isoembed.io.objects import to_trimesh

        return to_trimesh(self._surface)

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
        from isoembed.io.objects import to_pyvista

        return to_pyvista(self._surface)

    def _repr_html_(self) -> str | None:
        """What notebooks show: see `isoembed.plot.notebook`."""
        from isoembed.plot.notebook import notebook_html

        return notebook_html(self._surface)
