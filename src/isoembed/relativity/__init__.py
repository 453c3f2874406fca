"""For relativists: surfaces in slices of spacetime, horizon files, and quasi-local energies.

Units are geometric, G = c = 1.  The mean curvature of relativity is the trace k = k1 + k2.
"""

from isoembed.relativity.energies.embedded import EmbeddedSurface, embed_surface
from isoembed.relativity.energies.energies import Energies, Integrals
from isoembed.relativity.energies.mesh_energies import mesh_energies
from isoembed.relativity.energies.report import (
    energy_table,
    mesh_report,
    unembedded_report,
    wang_yau_report,
)
from isoembed.relativity.energies.time_function import TimeFunction
from isoembed.relativity.energies.wang_yau_energy import wang_yau
from isoembed.relativity.energies.wang_yau_result import WangYau
from isoembed.relativity.horizons.ahfinderdirect import read_ahfinderdirect
from isoembed.relativity.horizons.circumferences import Circumferences
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.expansion import ExpansionTest, expansion_test
from isoembed.relativity.horizons.finder import (
    constant_expansion,
    find_horizon,
    find_horizons,
    inner_horizon,
)
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.horizons.grid_file import read_grid_data, read_metric_grid, read_metric_or_grid
from isoembed.relativity.horizons.horizon import Horizon
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.horizons.horizon_format import HorizonFormat
from isoembed.relativity.horizons.horizon_shape import HorizonShape
from isoembed.relativity.horizons.multipoles import Multipoles
from isoembed.relativity.horizons.spectre import read_spectre
from isoembed.relativity.horizons.spin import Spin, find_spin
from isoembed.relativity.series.embed_series import embed_series
from isoembed.relativity.series.horizon_task import HorizonOptions, HorizonTask
from isoembed.relativity.series.kuibit_data import kuibit_shape
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.moments import moments
from isoembed.relativity.series.table import SeriesTable, write_table
from isoembed.relativity.spacetimes.boosted import BoostedSchwarzschild, Superposed
from isoembed.relativity.spacetimes.boyer_lindquist import BoyerLindquist
from isoembed.relativity.spacetimes.cartesian_grid import CartesianGrid
from isoembed.relativity.spacetimes.closed_form import kerr_surface
from isoembed.relativity.spacetimes.conformally_flat import BrillLindquist, IsotropicSchwarzschild
from isoembed.relativity.spacetimes.element_grid import Element, ElementGrid
from isoembed.relativity.spacetimes.kerr import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    embeddability,
    smarr_limit,
)
from isoembed.relativity.spacetimes.kerr_schild import KerrSchild
from isoembed.relativity.spacetimes.mapped_surface import MappedSurface
from isoembed.relativity.spacetimes.painleve_gullstrand import PainleveGullstrand
from isoembed.relativity.spacetimes.slice_file import read_cartesian_grid
from isoembed.relativity.spacetimes.spectre_volume import read_spectre_volume
from isoembed.relativity.spacetimes.star_surface import StarSurface
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.relativity.spacetimes.three_geometry import AnalyticCallable, CallableGeometry, ThreeGeometry
from isoembed.relativity.spacetimes.translated import Translated

__all__ = [
    "AnalyticCallable",
    "BoostedSchwarzschild",
    "BoyerLindquist",
    "BrillLindquist",
    "CallableGeometry",
    "CartesianGrid",
    "Circumferences",
    "CoordinateShape",
    "CurvatureCheck",
    "Element",
    "ElementGrid",
    "EmbeddedSurface",
    "Energies",
    "ExpansionTest",
    "FoundHorizon",
    "Horizon",
    "HorizonFormat",
    "HorizonOptions",
    "HorizonShape",
    "HorizonTask",
    "Integrals",
    "IsotropicSchwarzschild",
    "KerrNewmanErgosphere",
    "KerrNewmanHorizon",
    "KerrNewmanSphere",
    "KerrSchild",
    "MappedSurface",
    "Moment",
    "Multipoles",
    "PainleveGullstrand",
    "SeriesTable",
    "Spin",
    "StarSurface",
    "Superposed",
    "Surface",
    "SurfaceData",
    "ThreeGeometry",
    "TimeFunction",
    "Translated",
    "WangYau",
    "constant_expansion",
    "embed_series",
    "embed_surface",
    "embeddability",
    "energy_table",
    "expansion_test",
    "find_horizon",
    "find_horizons",
    "find_spin",
    "inner_horizon",
    "kerr_surface",
    "kuibit_shape",
    "mesh_energies",
    "mesh_report",
    "moments",
    "read_ahfinderdirect",
    "read_cartesian_grid",
    "read_grid_data",
    "read_horizon",
    "read_metric_grid",
    "read_metric_or_grid",
    "read_spectre",
    "read_spectre_volume",
    "smarr_limit",
    "unembedded_report",
    "wang_yau",
    "wang_yau_report",
    "write_table",
]
