"""Pictures of a simulation: time series, ParaView files, films and pages.

They depend only on the results of a run, in any order; equal results yield identical files.
"""

from isoembed.plot.series.curves import FIGURES, series_figure, series_figures, write_series_figure
from isoembed.plot.series.film import write_series_film
from isoembed.plot.series.page import write_series_page
from isoembed.plot.series.paraview import PARAVIEW_ENDINGS, write_paraview
from isoembed.plot.series.stills import horizon_figures

__all__ = [
    "FIGURES",
    "PARAVIEW_ENDINGS",
    "horizon_figures",
    "series_figure",
    "series_figures",
    "write_paraview",
    "write_series_figure",
    "write_series_film",
    "write_series_page",
]
