"""Color maps of pages and pictures.

Both ramps are curves in OKLCh, the polar form of the space of Ottosson, "A perceptual color space for image
processing" (2020).  The one of a page rises evenly in lightness, from dark violet over teal to light yellow,
to be read without telling hues apart.  Where values have both signs, a diverging ramp shows which: blue below
zero, orange above, and nearly white at zero.
"""

import numpy as np

from isoembed.arrays import Floats

LIGHTNESS = (0.36, 0.93)
HUE = (292.0, 102.0)  # degrees
ZERO, FAR = 0.92, 0.50  # lightness at zero, and at the value that is farthest from it
BLUE, ORANGE, STRONG = 252.0, 45.0, 0.145  # degrees, degrees, chroma
CHROMA = (0.102, 0.17, 0.4)  # least, growth and place of the least: just within what screens show

# Ottosson's matrices: from L, a, b to the cube roots of cone responses, and from these to linear RGB.
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
    """Return colors as ``#rrggbb``, from dark to light.

    Parameters
    ----------
    count : int
        How many, evenly spaced.
    """
    share = np.linspace(0.0, 1.0, count)
    lightness, hue = (low + (high - low) * share for low, high in (LIGHTNESS, np.radians(HUE)))
    least, growth, place = CHROMA
    chroma = least + growth * (share - place) ** 2
    return _hexadecimal(lightness, chroma, hue)


def diverging(count: int, low: float, high: float) -> list[str]:
    """Return colors as ``#rrggbb`` for evenly spaced values from low < 0 to high > 0; zero is nearly white.

    At the same distance from zero they are as strong on both sides.
    """
    share = np.linspace(low, high, count) / max(-low, high)
    lightness = ZERO + (FAR - ZERO) * np.abs(share)
    hue = np.radians(np.where(share < 0, BLUE, ORANGE))
    return _hexadecimal(lightness, STRONG * np.sqrt(np.abs(share)) * np.minimum(1.0, 4 * np.abs(share)), hue)


def _hexadecimal(lightness: Floats, chroma: Floats, hue: Floats) -> list[str]:
    lab = np.column_stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)])
    rgb = np.clip((lab @ TO_CONES.T) ** 3 @ TO_RGB.T, 0.0, 1.0)
    screen = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)  # sRGB, IEC 61966-2-1
    return ["#" + bytes(color).hex() for color in np.rint(255 * screen).astype(np.uint8)]
