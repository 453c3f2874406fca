"""Perforated folds: dashes that leave material at both ends."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.gluing.dashes import FEWEST
from isoembed.papercraft.material import Material


def pieces(line: Floats, material: Material) -> Floats:
    """Pieces of a fold to be cut or scored, shape (m, 2, 2).

    On a length l, n = floor((l - gap) / (dash + gap)) dashes leave n + 1 gaps of (l - n dash) / (n + 1),
    which are at least as wide as `Material.gap`.  Folds too short for three dashes have shorter ones.

    Parameters
    ----------
    line : ndarray, shape (2, 2)
        Endpoints of the fold, mm.
    material : Material
    """
    if material.bends == "score":
        return line[None]
    length = float(np.hypot(*(line[1] - line[0])))
    dash, gap = material.dash, material.gap
    n = int((length - gap) / (dash + gap))
    if n < FEWEST:  # readers of the file would not recognize a single fold
        n = FEWEST
        dash *= length / (n * dash + (n + 1) * gap)
    dash = max(dash - material.kerf, dash / 2)  # the beam cuts half its width beyond either end
    gap = (length - n * dash) / (n + 1)
    begins = (gap + (dash + gap) * np.arange(n)) / length
    parts = np.stack([begins, begins + dash / length], axis=1)
    return np.asarray(line[0] + parts[..., None] * (line[1] - line[0]))
