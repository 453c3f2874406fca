"""Common horizons of black holes at rest: are all found, and where do they end?

Brill-Lindquist slices: pairs with mass ratios 1 : 1 to 1 : 100, upright, tilted and off center, 0.3 to 1e-3
below the end of the common horizon; groups of three and four holes as far below the end of theirs, relative
to the distances, to which the horizon is followed by Newton's method alone from where the holes are close.
Areas of some pairs are compared with shooting.

    python benchmarks/common_horizons.py [--pairs 500] [--groups 50] [--ratios 1 4 100]
"""

import argparse
import time

import numpy as np
from scipy.integrate import solve_ivp

from isoembed import NoHorizon
from isoembed.relativity import BrillLindquist, StarSurface, find_horizon, find_horizons
from isoembed.relativity.horizons.found_horizon import horizon_near
from isoembed.relativity.horizons.newton import NoConvergence, solve
from isoembed.relativity.horizons.radial_image import discretized, in_degree, recentered

RATIOS = (1.0, 1.5, 7.0 / 3.0, 4.0, 9.0, 20.0, 50.0, 100.0)
PUBLISHED = {1.0: 0.76619743, 7.0 / 3.0: 0.7375, 4.0: 0.698, 9.0: 0.634}
"""The first one by shooting, the others by following the horizon in steps of 5e-4."""
PLACES = (
    ("upright", np.array([0.0, 0.0, 1.0]), np.zeros(3)),
    ("tilted", np.array([0.48, 0.6, 0.64]), np.zeros(3)),
    ("off center", np.array([0.0, -0.6, 0.8]), np.array([0.3, -0.2, 0.5])),
)
SHOT = 10
"""One of so many areas is compared with shooting."""


def pair(ratio, d, axis=PLACES[0][1], origin=PLACES[0][2]):
    """Two holes of mass 1 together, the lighter one on the side of the axis."""
    m = 1.0 / (1.0 + ratio)
    return BrillLindquist((m, 1.0 - m), (origin + 0.5 * d * axis, origin - 0.5 * d * axis))


def end(ratio):
    """The largest distance with a common horizon, where its stability eigenvalue is zero.

    Its square is linear in the distance there.  The horizon is followed by Newton's method, each time nine
    tenths of the way to the zero.
    """
    d = 0.45
    near = find_horizon(pair(ratio, d))
    (before, squared), target = (d, near.stability**2), d + 0.02
    while True:
        try:
            horizon = horizon_near(pair(ratio, target), near.surface, symmetric=True)
        except NoConvergence:
            target = 0.5 * (d + target)
            if target - d < 1e-8:  # the highest degree does not resolve it
                return d
            continue
        near, d, fall = horizon, target, squared - horizon.stability**2
        zero = d + horizon.stability**2 * (d - before) / fall if fall > 0.0 else np.inf
        if zero - d < 1e-8:
            return zero
        before, squared = d, horizon.stability**2
        target = d + min(0.02, 0.9 * (zero - d))


def shot_area(ratio, d):
    """The area of the outer common horizon by shooting from the axis above the lighter hole.

    In the half plane (rho, z) the tangent has the angle a, and the mean curvature vanishes where
    a' = -sin(a) / rho + 4 (n . grad psi) / psi.
    """
    m = 1.0 / (1.0 + ratio)
    masses, heights = np.array([m, 1.0 - m]), np.array([0.5 * d, -0.5 * d])

    def psi(rho, z):
        r = np.sqrt(rho**2 + (z - heights) ** 2)
        cube = 0.5 * masses / r**3
        return 1.0 + 0.5 * np.sum(masses / r), -rho * cube.sum(), -np.sum(cube * (z - heights))

    def slope(_, y):
        rho, z, a, _ = y
        p, p_rho, p_z = psi(rho, z)
        bend = -np.sin(a) / rho + 4.0 * (np.cos(a) * p_z - np.sin(a) * p_rho) / p
        return [np.cos(a), np.sin(a), bend, 2.0 * np.pi * rho * p**4]

    def turned(_, y):
        return y[2] + np.pi

    def axis(_, y):
        return y[0] - 1e-6

    turned.terminal = axis.terminal = True
    axis.direction = -1.0

    def shot(z0):
        p, _, p_z = psi(0.0, z0)
        s = 1e-5
        bend = 2.0 * p_z / p
        start = [s, z0 + 0.5 * bend * s**2, bend * s, np.pi * s**2 * p**4]
        return solve_ivp(
            slope, (0.0, 10.0), start, method="DOP853", rtol=1e-12, atol=1e-13, events=(turned, axis)
        )

    def side(z0):
        return len(shot(z0).t_events[0]) > 0  # it turns back before it meets the axis

    top = heights[0] + np.geomspace(1.0, 0.05 * m, 200)
    before = side(top[0])
    k = next(k for k in range(1, len(top)) if side(top[k]) != before)
    high, low = top[k - 1], top[k]
    while high - low > 1e-15 * abs(high):
        middle = 0.5 * (high + low)
        if middle in (high, low):
            break
        high, low = (middle, low) if side(middle) == before else (high, middle)
    # The two shots part where the other pole is near: what is missing there is a disc.
    both = [shot(z) for z in (high, low)]
    rho = min(float(np.min(each.y[0, len(each.t) // 2 :])) for each in both)
    z, area = both[0].y[1, -1], both[0].y[3, -1]
    return float(area + np.pi * max(rho, 1e-6) ** 2 * psi(0.0, z)[0] ** 4)


def pairs(count, ratios):
    """A row for each mass ratio; returns the number of horizons that were not found."""
    print("ratio       end           of  found  absent  unresolved  area - shooting   s, median  largest")
    each, missed = max(1, count // len(ratios)), 0
    for ratio in ratios:
        last = end(ratio)
        gaps = np.geomspace(0.3, 1e-3, each)
        found, absent, open_, off, seconds = 0, 0, 0, 0.0, []
        for k, gap in enumerate(gaps):
            place, axis, origin = PLACES[k % len(PLACES)]
            start = time.process_time()
            try:
                horizons = find_horizons(pair(ratio, last - gap, axis, origin))
            except NoHorizon as error:
                open_ += error.barriers is not None
                absent += error.barriers is None
                print(f"    gap {gap:.2g}, {place}: {error}", flush=True)
                continue
            finally:
                seconds.append(time.process_time() - start)
            if len(horizons) > 1:
                absent += 1
                print(f"    gap {gap:.2g}, {place}: {len(horizons)} separate", flush=True)
                continue
            found += 1
            if k % SHOT == 0:
                off = max(off, abs(horizons[0].area - shot_area(ratio, last - gap)))
        print(
            f"1 : {ratio:<7.4g} {last:.9f}  {each:4d}  {found:5d}  {absent:6d}  {open_:10d}  {off:15.1e}"
            f"  {np.median(seconds):10.2f}  {max(seconds):7.1f}",
            flush=True,
        )
        if ratio in PUBLISHED:
            print(f"    published {PUBLISHED[ratio]}")
        missed += each - found
    return missed


def groups(count):
    """Three or four holes, 0.3 to 1e-3 below the end; returns the number of horizons that were not found."""
    rng, missed, seconds = np.random.default_rng(39), 0, []
    gaps = np.geomspace(0.3, 1e-3, max(count, 1))
    for k in range(count):
        n = 3 + k % 2
        masses = rng.uniform(0.5, 1.5, n)
        masses /= masses.sum()
        at = rng.normal(size=(n, 3))
        at -= masses @ at
        at /= np.linalg.norm(at, axis=1).max()
        path = scales(masses, at)
        last = path[-1][0]
        s = (1.0 - gaps[k]) * last
        near = max((each for each in path if each[0] <= s), key=lambda each: each[0])[1]
        truth = find_horizon(BrillLindquist(masses, s * at), near).area
        start = time.process_time()
        try:
            horizons = find_horizons(BrillLindquist(masses, s * at))
            right = len(horizons) == 1 and abs(horizons[0].area - truth) < 1e-8 * truth
        except NoHorizon as error:
            print(f"    {error}")
            right = False
        seconds.append(time.process_time() - start)
        missed += not right
        print(
            f"{n} holes, end at scale {last:.4f}, gap {gaps[k]:.2g}, area {truth:.8f}: "
            f"{'found' if right else 'MISSED'}, {seconds[-1]:.1f} s",
            flush=True,
        )
    if count:
        middle, longest = np.median(seconds), max(seconds)
        print(f"{count - missed} of {count} found, {middle:.1f} s in the median, {longest:.1f} at most")
    return missed


def scales(masses, at):
    """Scales of the positions with the horizon there, up to the end; by Newton's method in one degree."""
    near, s, step = StarSurface.sphere((0.0, 0.0, 0.0), 0.5), 0.15, 0.04
    path = []
    while step > 5e-4:
        geometry = BrillLindquist(masses, (s + step) * at)
        try:
            guess = in_degree(near, 48, False)
            solution = solve(discretized(geometry, guess), guess.coefficients, 0.0, 1e-10)
        except NoConvergence:
            step *= 0.5
            continue
        found = StarSurface(guess.center, guess.harmonics, solution.iterate.f)
        near, s = recentered(found), s + step
        path.append((s, near))
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pairs", type=int, default=500)
    parser.add_argument("--groups", type=int, default=50)
    parser.add_argument("--ratios", type=float, nargs="+", default=RATIOS)
    options = parser.parse_args()
    missed = pairs(options.pairs, options.ratios) if options.pairs else 0
    missed += groups(options.groups)
    print(f"{missed} common horizons were not found")


if __name__ == "__main__":
    main()
