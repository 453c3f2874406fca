"""Deviations of surfaces whose lengths have errors, and proven bounds, against surfaces with such lengths.

    python benchmarks/deviation.py [--size N] [--noises N] [--bodies NAME ...] [--largest E]

For every body and quantity: how many noises stay within the bound everywhere, and the largest change over the
bound, where all lengths are off by the largest error, a power of ten in mean edge lengths, for which there is
a proof, with random signs; and the percentage of changes, of all noises and places, within two standard
deviations, for normal errors of 1e-8 mean edge lengths.
"""

import argparse
import time

import numpy as np

import isoembed
from certificates import BODIES
from isoembed import PolyhedralMetric, embed
from isoembed.embedding.comparison import differences
from isoembed.gallery import triangulate
from isoembed.surface.changes import INTEGRALS, LOCAL
from isoembed.surface.rigidity import LengthSystem, length_residuals

QUANTITIES = (*LOCAL, *INTEGRALS)
SIGMA = 1e-8


class Noises:
    """Surfaces near one, by Newton's method, and how they differ from it."""

    def __init__(self, surface):
        """Keep the surface, in the unit of its normalized metric."""
        self.metric = surface.metric.normalized
        self.vertices = surface.vertices / surface.metric.unit
        self.system = LengthSystem(self.metric.triangulation)

    def change(self, errors):
        """The changes of all quantities when lengths are off by errors, (E,), in mean edge lengths."""
        t, lengths, x = self.metric.triangulation, self.metric.lengths, self.vertices
        noisy = lengths + errors * self.metric.mean_length
        for _ in range(4):
            x = x - self.system.step(x, noisy, length_residuals(t, x, noisy))
        missed = np.abs(length_residuals(t, x, noisy)).max()
        if missed > 1e-13:
            raise ArithmeticError(f"Newton's method misses a length by {missed:.1e}")
        return differences(t, self.vertices, x)


def largest_proven(surface, exponents):
    """The largest power of ten, in mean edge lengths, for which there is a bound, and the bound."""
    for exponent in exponents:
        error = 10.0**exponent
        bound = isoembed.Sensitivity(surface).deviation_bound(error * surface.metric.mean_length)
        if not bound.reason:
            return error, bound
    raise ArithmeticError(bound.reason)


def rows(name, body, size, count, largest):
    """Measure one body; print its lines, and return what is wrong."""
    rng = np.random.default_rng(0)
    surface = embed(PolyhedralMetric.from_mesh(*triangulate(body, size)))
    noises, unit = Noises(surface), surface.metric.unit
    edges = len(surface.metric.lengths)
    error, bound = largest_proven(surface, range(int(np.floor(np.log10(largest))), -18, -1))
    bound, sigma = (
        bound.scaled(1 / unit),
        isoembed.Sensitivity(surface).deviation(SIGMA * surface.metric.mean_length).scaled(1 / unit),
    )
    shares = {quantity: [] for quantity in QUANTITIES}
    within = {quantity: [] for quantity in QUANTITIES}
    for _ in range(count):
        extreme = noises.change(error * rng.choice([-1.0, 1.0], edges))
        normal = noises.change(SIGMA * rng.standard_normal(edges))
        for quantity in QUANTITIES:
            changes, limits = np.abs(getattr(extreme, quantity)), getattr(bound, quantity)
            shares[quantity].append(np.max(changes / limits))
            inside = np.abs(getattr(normal, quantity)) <= 2 * getattr(sigma, quantity)
            within[quantity].append(np.mean(inside))
    print(f"{name}, {size} vertices: proven for errors of {error:.0e}")
    wrong = []
    for quantity in QUANTITIES:
        inside, mean = sum(share <= 1 for share in shares[quantity]), 100 * np.mean(within[quantity])
        print(
            f"  {quantity:26} inside the bound {inside:4d} of {count}, "
            f"at most {max(shares[quantity]):.1e} of it; inside two sigma {mean:5.1f} %",
            flush=True,
        )
        if inside < count:
            wrong.append(f"{name}: {quantity} is outside the bound in {count - inside} noises")
        if not 90 <= mean <= 99:
            wrong.append(f"{name}: {quantity} is inside two sigma in {mean:.1f} %")
    return wrong


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", type=int, default=1000, metavar="N", help="vertices")
    parser.add_argument("--noises", type=int, default=100, metavar="N")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=BODIES, metavar="NAME")
    parser.add_argument("--largest", type=float, default=1e-6, metavar="E", help="error that is tried first")
    options = parser.parse_args()
    start, wrong = time.process_time(), []
    for name in options.bodies:
        wrong += rows(name, BODIES[name], options.size, options.noises, options.largest)
    for said in wrong:
        print(f"** {said}")
    print(f"{time.process_time() - start:.0f} s; {len(wrong)} numbers are not as they should be")


if __name__ == "__main__":
    main()
