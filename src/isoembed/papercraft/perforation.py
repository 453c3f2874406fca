"""Perforated folds: dashes that leave material at both ends."""

import numpy as np

from isoembed.arrays import Floats
from isoembed.papercraft.material import Material

FEWEST = 3  # dashes, by which whoever reads the file sees that they are one fold


def pieces(line: Floats, material: Material) -> Floats:
    """Pieces of a fold that are cut or scored, shape (m, 2, 2).

    With n = floor((l - gap) / (dash + gap)) dashes on a length l, n + 1 gaps of (l - n dash) / (n + 1) are
    left, which are at least as wide as `Material.gap`.  A fold too short for three dashes has shorter ones.

    Parameters
    ----------
    line : ndarray, shape (2, 2)
        Its ends, mm.
    material : Material
    """
    if material.bends == "score":
        return line[None]
    length = float(np.hypot(*(line[1] - line[0])))
    dash, gap = material.dash, material.gap
    n = int((length - gap) / (dash + gap))
    if n < FEWEST:
        n = FEWEST
        dash *= length / (n * dash + (n + 1) * gap)
    dash = max(dash - material.kerf, dash / 2)  # a beam cuts half of its width beyond either end
    gap = (length - n * dash) / (n + 1)
    begins = (gap + (dash + gap) * np.arange(n)) / length
    parts = np.stack([begins, begins + dash / length], axis=1)
    return np.asarray(line[0] + parts[..., None] * (line[1] - line[0]))
