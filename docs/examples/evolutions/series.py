"""A series of horizons.

A hole precesses and spins up; three of its horizons, each in its own slice. The results make a table and
plots against time with bands of their errors.
"""

import numpy as np

from isoembed.plot.series import series_figure
from isoembed.relativity import KerrSchild, SeriesTable, StarSurface, embed_series, write_table


def moment(time):
    """Time, surface and slice."""
    geometry = KerrSchild(1.0, (0.5 + 0.1 * time) * np.array([0.6 * np.cos(time), 0.6 * np.sin(time), 0.8]))
    return time, StarSurface.from_radius(geometry.spheroid(geometry.horizon)), geometry


results = list(embed_series(map(moment, np.linspace(0.0, 2.0, 3)), vertices=100))
assert all(result.status == "embedded" for result in results)
write_table("table.csv", results)
picture = series_figure(SeriesTable.of(results), ["irreducible_mass", "integrated_mean_curvature"])
picture.savefig("series.png", dpi=150)
