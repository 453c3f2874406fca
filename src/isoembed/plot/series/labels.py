"""Labels of quantities in time series, and colors of series."""

from __future__ import annotations

from collections.abc import Iterable

from isoembed.relativity.series.table import Row

SYMBOLS = {
    "area": "area\n$A$",
    "irreducible_mass": "irreducible mass\n$M_\\mathrm{irr}$",
    "christodoulou_mass": "Christodoulou mass\n$M$",
    "J": "angular momentum\n$J$",
    "dimensionless_spin": "spin  $J/M^2$\n$\\chi$",
    "axis": "axis of the spin\n$\\hat s$",
    "integrated_mean_curvature": "total mean curvature\n$\\int\\! H\\,\\mathrm{d}A$",
    "hawking": "Hawking energy\n$E_\\mathrm{H}$",
    "brown_york": "Brown-York energy\n$E_\\mathrm{BY}$",
    "liu_yau": "Kijowski-Liu-Yau\nenergy  $E_\\mathrm{KLY}$",
    "wang_yau": "Wang-Yau energy\n$E_\\mathrm{WY}$",
    "residual": "relative error\nof lengths",
    "degree": "degree of the\nharmonics",
}
"""Labels of the table columns, in TeX between dollar signs."""
AXIS = {"axis": ("axis_x", "axis_y", "axis_z")}
"""Columns shown together in one panel."""
CURVATURE = "mean curvature  $H = (k_1 + k_2)/2$,  1/length"
"""Label of the color scale in pictures of horizons."""
FACTS = {"irreducible_mass": "Mᵢᵣᵣ", "christodoulou_mass": "M", "dimensionless_spin": "χ"}
"""Symbols of the numbers beside a horizon, as plain text."""
COLORS = ("#0072b2", "#d55e00", "#1c2430", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def colors_of(series: Iterable[str]) -> dict[str, str]:
    """Colors of series: seven, distinguishable with color blindness, repeated cyclically.

    Okabe and Ito, "Color universal design" (2008).
    """
    return {name: COLORS[k % len(COLORS)] for k, name in enumerate(series)}


def escaped(text: str) -> str:
    """Text with dollar signs escaped for matplotlib."""
    return text.replace("$", r"\$")


def power_of_ten(value: float) -> str:
    """Number with one significant digit, in TeX."""
    mantissa, _, power = f"{value:.0e}".partition("e")
    if value == 0 or -3 < int(power) < 4:
        return f"{value:.1g}"
    return rf"${mantissa} \times 10^{{{int(power)}}}$"


def facts_of(row: Row, between: str) -> str:
    """Masses and spin of an embedded horizon, or its status."""
    if "residual" not in row.numbers:
        return row.status
    values = ((symbol, row.numbers.get(name)) for name, symbol in FACTS.items())
    return between.join(f"{symbol} = {value:.4f}" for symbol, value in values if value is not None)
