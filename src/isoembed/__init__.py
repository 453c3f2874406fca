"""Isometric embedding of polyhedral metrics in Euclidean, hyperbolic and spherical space.

Give the triangles of a surface and the length of every edge; get the surface back::

    import isoembed

    metric = isoembed.PolyhedralMetric(faces, lengths, edges)
    surface = isoembed.embed(metric)
    surface.vertices

The public names are imported on first use, so that ``import isoembed`` costs nothing.
"""

from importlib import import_module
from importlib.util import find_spec

import lazy_loader

from isoembed import cimports as _cimports  # noqa: F401
from isoembed.version import __version__ as __version__

_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ = ["__version__", *__all__]


def __getattr__(name: str) -> object:
    try:
        return _imported(name)
    except AttributeError:
        if name.startswith("_") or find_spec(f"{__name__}.{name}"):  # a module, which the import system finds
            raise
        from isoembed.similar_names import did_you_mean

        suggestion = _in_subpackage(name) or did_you_mean(name, __all__)
        raise AttributeError(f"module 'isoembed' has no attribute {name!r}{suggestion}") from None


def _in_subpackage(name: str) -> str:
    """Question for a name that a subpackage has, as ``read_metric`` of `isoembed.io`."""
    for package in ("io", "plot", "gluing", "papercraft", "smooth", "sheets", "proof", "relativity"):
        if hasattr(import_module(f"{__name__}.{package}"), name):
            return f"; did you mean 'isoembed.{package}.{name}'?"
    return ""
