"""A sequence of surfaces, each embedded from the one before, against as many embedded from nothing.

    python benchmarks/horizon_sequence.py [--count N] [--only FAMILY ...] [--json FILE]

Families: "pair", spheres of coordinate radius 3 about two black holes of masses .6 and .4 at rest (Brill and
Lindquist) that come from 1.2 to .3 apart while their line, tilted to the z-axis, turns twice; "deformed", the
same in surfaces that are flattened along another axis; "precessing", the horizons of Kerr-Schild slices whose
spin grows from .3 to .7 while it turns about the z-axis at an angle of .7; "kerr", horizons of spin 0 to .86,
symmetric about z.

Printed are seconds of the clock (of the processor in brackets) for all embeddings with their energies, both
ways, the ratio of the seconds of the processor, the largest difference of the Kijowski-Liu-Yau energies and
the largest of the estimated errors beside it, the largest error against the surface of revolution where there
is one, the least Gaussian curvature, the degrees of the harmonics, and the first and the last energy.  The
first surface of a sequence is embedded from nothing both ways.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from isoembed.relativity import BrillLindquist, KerrNewmanHorizon, KerrSchild, StarSurface, embed_surface

MASSES = (0.6, 0.4)
RADIUS = 3.0
TILT = 0.7
TURNS = 2.0


def turning(t):
    """A unit vector that turns about the z-axis."""
    phi = 2.0 * np.pi * TURNS * t
    return np.array([np.sin(TILT) * np.cos(phi), np.sin(TILT) * np.sin(phi), np.cos(TILT)])


def holes(t):
    """Two black holes at rest about their center of mass."""
    apart = (1.2 * (1.0 - t) + 0.3 * t) * turning(t)
    return BrillLindquist(MASSES, (MASSES[1] * apart, -MASSES[0] * apart))


def pair(t):
    return StarSurface.sphere((0.0, 0.0, 0.0), RADIUS).data(holes(t))


def deformed(t):
    axis = turning(0.5 * t + 0.2)

    def radius(u):
        return RADIUS * (1.0 - 0.05 * (1.5 * (u @ axis) ** 2 - 0.5))

    return StarSurface.from_radius(radius).data(holes(t))


def growing_spin(t):
    return 0.3 + 0.4 * t


def precessing(t):
    geometry = KerrSchild(1.0, growing_spin(t) * turning(t))
    surface = StarSurface.from_radius(geometry.spheroid(geometry.horizon))
    return replace(surface.data(geometry), marginal=True)


def kerr_spin(t):
    return 0.86 * t


def kerr(t):
    return KerrNewmanHorizon(1.0, kerr_spin(t)).data()


FAMILIES = {"pair": pair, "deformed": deformed, "precessing": precessing, "kerr": kerr}
SPINS = {"precessing": growing_spin, "kerr": kerr_spin}
"""Of the families whose energies a surface of revolution tells."""


def embedded(surfaces, warm):
    """Seconds of the clock and of the processor, and the embedded surfaces."""
    found, before = [], None
    clock, cpu = time.perf_counter(), time.process_time()
    for data in surfaces:
        surface = embed_surface(data, start=before)
        before = surface if warm else None
        energy(surface)  # computed here and kept
        found.append(surface)
    return time.perf_counter() - clock, time.process_time() - cpu, found


def energy(surface):
    return surface.energies.liu_yau.value


def measured(name, count):
    """One family."""
    times = np.linspace(0.0, 1.0, count)
    surfaces = [FAMILIES[name](t) for t in times]
    embed_surface(surfaces[0])  # compiles, or loads what was compiled
    cold, cold_cpu, one_by_one = embedded(surfaces, warm=False)
    warm, warm_cpu, followed = embedded(surfaces, warm=True)
    exact = None
    if name in SPINS:
        profiles = [KerrNewmanHorizon(1.0, SPINS[name](t)).profile() for t in times]
        references = [profile.integrated_mean_curvature / (4.0 * np.pi) for profile in profiles]
        exact = max(abs(energy(s) - e) for s, e in zip(followed, references, strict=True))
    degrees = [surface.embedding.harmonics.degree for surface in followed]
    return {
        "family": name,
        "surfaces": count,
        "cold": cold,
        "cold cpu": cold_cpu,
        "warm": warm,
        "warm cpu": warm_cpu,
        "ratio": cold_cpu / warm_cpu,
        "difference": max(abs(energy(a) - energy(b)) for a, b in zip(one_by_one, followed, strict=True)),
        "estimated": max(surface.energies.liu_yau.error for surface in followed),
        "exact": exact,
        "least K": min(surface.embedding.least_curvature for surface in followed),
        "degrees": [min(degrees), max(degrees)],
        "energies": [energy(surface) for surface in followed],
    }


HEAD = (
    f"{'family':<10} {'surfaces':>8} {'cold s':>15} {'warm s':>15} {'ratio':>5} {'difference':>10} "
    f"{'estimated':>9} {'exact':>7} {'least K':>8} {'degrees':>8}  energies"
)


def line(row):
    """A line of the table."""
    exact = "-" if row["exact"] is None else f"{row['exact']:.0e}"
    times = [f"{row[way]:.1f} ({row[f'{way} cpu']:.1f})" for way in ("cold", "warm")]
    return (
        f"{row['family']:<10} {row['surfaces']:>8} {times[0]:>15} {times[1]:>15} {row['ratio']:>5.1f} "
        f"{row['difference']:>10.0e} {row['estimated']:>9.0e} {exact:>7} {row['least K']:>8.4f} "
        f"{row['degrees'][0]:>3} - {row['degrees'][1]:<2}  "
        f"{row['energies'][0]:.10f} ... {row['energies'][-1]:.10f}"
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--count", type=int, default=8, metavar="N", help="surfaces in a sequence (default 8)"
    )
    parser.add_argument("--only", nargs="+", choices=FAMILIES, default=list(FAMILIES), metavar="FAMILY")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows to this file")
    options = parser.parse_args()
    if options.count < 2:
        parser.error(f"--count must be at least 2, not {options.count}")
    rows = []
    print(HEAD, flush=True)
    for name in options.only:
        rows.append(measured(name, options.count))
        print(line(rows[-1]), flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
