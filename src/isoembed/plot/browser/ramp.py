"""Color maps of pages and pictures.

Both color ramps are curves in OKLCh, the polar form of Oklab (Ottosson, "A perceptual color space for image
processing", 2020).  The default ramp has uniformly increasing lightness, from dark violet over teal to light
yellow, and is readable without distinguishing hues.  A diverging ramp shows the sign of values: blue below
zero, orange above, and nearly white at zero.
"""

import numpy as np

from isoembed.arrays import Floats

# Ottosson's matrices: from L, a, b to cube roots of cone responses, and from cone responses to linear RGB.
TO_CONES = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
TO_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def ramp(count: int) -> list[str]:
    """Colors as ``#rrggbb``, from dark to light.

    Parameters
    ----------
    count : int
        Number of evenly spaced colors.
    """
    share = np.linspace(0.0, 1.0, count)
    lightness, hue = (low + (high - low) * share for low, high in ((0.36, 0.93), np.radians((292.0, 102.0))))
    chroma = 0.102 + 0.17 * (share - 0.4) ** 2  # just within the sRGB gamut
    return _hexadecimal(lightness, chroma, hue)


def diverging(count: int, low: float, high: float) -> list[str]:
    """Colors as ``#rrggbb`` for evenly spaced values from low < 0 to high > 0; zero is nearly white.

    Values of equal magnitude have equally strong colors.
    """
    share = np.linspace(low, high, count) / max(-low, high)
    lightness = 0.92 + (0.50 - 0.92) * np.abs(share)
    hue = np.radians(np.where(share < 0, 252.0, 45.0))
    return _hexadecimal(lightness, 0.145 * np.sqrt(np.abs(share)) * np.minimum(1.0, 4 * np.abs(share)), hue)


def _hexadecimal(lightness: Floats, chroma: Floats, hue: Floats) -> list[str]:
    lab = np.column_stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)])
    rgb = np.clip((lab @ TO_CONES.T) ** 3 @ TO_RGB.T, 0.0, 1.0)
    screen = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)  # sRGB, IEC 61966-2-1
    return ["#" + bytes(color).hex() for color in np.rint(255 * screen).astype(np.uint8)]
