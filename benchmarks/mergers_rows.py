"""Rows of the tables of mergers.py, and the lines below them."""

from dataclasses import dataclass

import numpy as np

ROUNDING = 1e-13
ROOT = 1e-6  # asked of distances
POWER = 1.7  # of the number of harmonics, asked of seconds
SIXTY = 60.0  # seconds in which a refusal is asked for


@dataclass(frozen=True)
class Row:
    """What was found of one input: errors of int H dA, relative, or why there is none."""

    name: str
    seconds: float
    asked: float  # of the true error, 0 where a refusal is asked for
    true: float | None = None
    stated: float | None = None
    residual: float | None = None
    degree: int | None = None
    mass: float | None = None
    refusal: str = ""

    @property
    def ratio(self):
        if self.true is None or self.true <= ROUNDING:
            return 0.0
        return self.true / self.stated if self.stated > 0.0 else np.inf

    @property
    def good(self):
        if self.asked == 0.0:
            return bool(self.refusal) and self.seconds <= SIXTY
        return self.true is not None and self.true <= self.asked and self.ratio <= 1.0

    def __str__(self):
        if self.true is None:
            return f"{self.name:52} {self.seconds:6.1f} s  refused: {self.refusal}"
        mass = "" if self.mass is None else f"  mass {self.mass:7.1e}"
        verdict = "" if self.good else "   <-- asked: " + (f"{self.asked:.0e}" if self.asked else "a refusal")
        return (
            f"{self.name:52} {self.seconds:6.1f} s  true {self.true:7.1e}  stated {self.stated:7.1e}  "
            f"ratio {self.ratio:7.2g}  residual {self.residual:7.1e}  degree {self.degree:3d}{mass}{verdict}"
        )


@dataclass(frozen=True)
class Root:
    """A distance that was found, and the true one."""

    name: str
    value: float
    truth: float
    seconds: float

    def __str__(self):
        off = abs(self.value - self.truth)
        verdict = "" if off <= ROOT else f"   <-- asked: {ROOT:.0e}"
        times = f"{self.name:52} {self.seconds:6.1f} s"
        return f"{times}  {self.value:.9f}  true {self.truth:.9f}  off {off:.1e}{verdict}"


@dataclass(frozen=True)
class GridRow:
    """An energy on a grid; the power of the spacing is that since the grid before."""

    energy: str
    spacing: float
    value: float
    truth: float
    stated: float
    seconds: float
    power: float | None = None

    @property
    def off(self):
        return abs(self.value - self.truth)

    def __str__(self):
        power = "" if self.power is None else f"  power {self.power:.1f}"
        verdict = "" if self.off <= self.stated else "   <-- outside"
        return (
            f"{self.energy:12} spacing {self.spacing:4g}  {self.seconds:6.1f} s  {self.value:.12f}  "
            f"off {self.off:7.1e}  stated {self.stated:7.1e}{power}{verdict}"
        )


@dataclass(frozen=True)
class CostRow:
    """One solve; the power is that of (L + 1)^2 since the degree before."""

    name: str
    degree: int
    seconds: float
    adjoints: int
    memory: float  # GB
    residual: float
    power: float | None

    def __str__(self):
        power = "" if self.power is None else f"  power {self.power:.2f}"
        verdict = "" if self.power is None or self.power <= POWER else f"   <-- asked: {POWER}"
        return (
            f"{self.name:32} degree {self.degree:3d} {self.seconds:6.1f} s  {self.adjoints:5d} adjoints  "
            f"{self.memory:.2f} GB  residual {self.residual:.1e}{power}{verdict}"
        )


def summary(rows):
    """The last lines."""
    embedded = [r for r in rows if r.asked]
    given = [r for r in embedded if r.true is not None]
    if not rows:
        return
    ratios = np.array([r.ratio for r in given])
    print(f"\nto be embedded: {len(embedded)}, refused: {len(embedded) - len(given)} (asked: 0)")
    if given:
        worst = max(given, key=lambda r: r.ratio)
        print(f"as right as asked: {sum(r.true <= r.asked for r in given)} of {len(embedded)}")
        print(
            f"ratio above 1: {np.sum(ratios > 1.0)} (asked: 0); the largest {worst.ratio:.2g}: {worst.name}"
        )
        excess = [r.stated / max(r.true, ROUNDING) for r in given]
        print(f"median of stated over true: {np.median(excess):.3g}")
    refused = [r for r in rows if not r.asked]
    if refused:
        print(
            f"without an embedding: {len(refused)}, refused: {sum(bool(r.refusal) for r in refused)} "
            f"(asked: all), the slowest in {max(r.seconds for r in refused):.0f} s (asked: {SIXTY:.0f})"
        )
