"""A film of horizons.

The horizons of a series, turned and placed as in their slices, as a GIF; the picture is its last frame.
"""

import numpy as np
from PIL import Image

from isoembed.plot.series import write_series_film
from isoembed.relativity import KerrSchild, StarSurface, embed_series


def moment(time):
    """A hole that turns its axis."""
    geometry = KerrSchild(1.0, (0.8 * np.sin(time), 0.0, 0.8 * np.cos(time)))
    return time, StarSurface.from_radius(geometry.spheroid(geometry.horizon)), geometry


results = list(embed_series(map(moment, np.linspace(0.0, 1.5, 3)), vertices=100))
write_series_film("horizons.gif", results)
with Image.open("horizons.gif") as film:
    assert film.n_frames >= 3
    film.seek(film.n_frames - 1)
    film.convert("RGB").save("series_film.png")
