"""For relativists: surfaces in slices of spacetime, horizon files, and quasi-local energies.

Units are geometric, G = c = 1.  The mean curvature of relativity is the trace k = k1 + k2.
"""

from isoembed.relativity.ahfinderdirect import read_ahfinderdirect
from isoembed.relativity.boosted import BoostedSchwarzschild, Superposed
from isoembed.relativity.boyer_lindquist import BoyerLindquist
from isoembed.relativity.cartesian_grid import CartesianGrid, read_cartesian_grid
from isoembed.relativity.conformally_flat import BrillLindquist, IsotropicSchwarzschild
from isoembed.relativity.coordinate_shape import CoordinateShape
from isoembed.relativity.embedded import EmbeddedSurface, embed_surface
from isoembed.relativity.energies import Energies, Integrals
from isoembed.relativity.grid_file import read_metric_grid
from isoembed.relativity.horizon_file import read_horizon
from isoembed.relativity.kerr import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    embeddability,
    smarr_limit,
)
from isoembed.relativity.kerr_schild import KerrSchild
from isoembed.relativity.mesh_energies import mesh_energies
from isoembed.relativity.painleve_gullstrand import PainleveGullstrand
from isoembed.relativity.spectre import read_spectre
from isoembed.relativity.star_surface import StarSurface
from isoembed.relativity.surface_data import SurfaceData
from isoembed.relativity.three_geometry import AnalyticCallable, CallableGeometry, ThreeGeometry
from isoembed.relativity.time_function import TimeFunction
from isoembed.relativity.wang_yau_energy import WangYau, wang_yau

__all__ = [
    "AnalyticCallable",
    "BoostedSchwarzschild",
    "BoyerLindquist",
    "BrillLindquist",
    "CallableGeometry",
    "CartesianGrid",
    "CoordinateShape",
    "EmbeddedSurface",
    "Energies",
    "Integrals",
    "IsotropicSchwarzschild",
    "KerrNewmanErgosphere",
    "KerrNewmanHorizon",
    "KerrNewmanSphere",
    "KerrSchild",
    "PainleveGullstrand",
    "StarSurface",
    "Superposed",
    "SurfaceData",
    "ThreeGeometry",
    "TimeFunction",
    "WangYau",
    "embed_surface",
    "embeddability",
    "mesh_energies",
    "read_ahfinderdirect",
    "read_cartesian_grid",
    "read_horizon",
    "read_metric_grid",
    "read_spectre",
    "smarr_limit",
    "wang_yau",
]
