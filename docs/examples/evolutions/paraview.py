"""Horizons for ParaView.

A collection of files with all horizons at their times, each where it is in its slice. ParaView opens the
`.pvd`.
"""

from pathlib import Path

from isoembed.plot.series import series_figures, write_paraview
from isoembed.relativity import KerrSchild, StarSurface, embed_series


def moment(time):
    """A hole that spins up."""
    geometry = KerrSchild(1.0, (0.0, 0.0, 0.3 * time))
    return time, StarSurface.from_radius(geometry.spheroid(geometry.horizon)), geometry


results = list(embed_series(map(moment, (0.0, 1.0, 2.0)), vertices=100))
write_paraview("horizons.pvd", results)
assert Path("horizons.pvd").read_text().count("<DataSet") == 3
series_figures(results)["masses"].savefig("paraview.png", dpi=150)
