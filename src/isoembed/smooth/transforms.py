"""Resizing and truncation of spherical harmonic coefficients."""

import numpy as np

from isoembed.arrays import Floats, Mask
from isoembed.smooth.harmonics import Harmonics

ROUNDING = 1e-15  # rounding error of the highest harmonics of a function, relative to the largest
NEGLIGIBLE = 5e-17  # relative size below which harmonics are dropped


def resized(coefficients: Floats, old: Harmonics, new: Harmonics) -> Floats:
    """Coefficients (size, c) of functions in other harmonics, truncated or zero-padded."""
    place = {label: i for i, label in enumerate(zip(*new.labels, strict=True))}
    result = np.zeros((new.size, coefficients.shape[1]))
    for i, label in enumerate(zip(*old.labels, strict=True)):
        if label in place:
            result[place[label]] = coefficients[i]
    return result


def trimmed(coefficients: Floats, harmonics: Harmonics, needed: Mask) -> tuple[Floats, Harmonics]:
    """Coefficients (size, ...) truncated to the lowest degree and order that contain all needed ones."""
    degrees, orders = harmonics.labels
    fewer = Harmonics(int(degrees[needed].max()), int(np.abs(orders[needed]).max()))
    retained = (degrees <= fewer.degree) & (np.abs(orders) <= fewer.order)
    return coefficients[retained], fewer
