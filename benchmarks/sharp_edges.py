"""Bodies with sharp edges whose lengths have errors, and of which one may be wrong.

    python benchmarks/sharp_edges.py [--bodies NAME ...] [--errors E ...] [--blunders B ...] [--seeds N]

Errors are Gaussian, E mean edge lengths; a wrong length is off by B of these standard deviations in addition,
at an edge drawn at random; with B = 0 all lengths are right.  Printed for each body: E, B, the seed, the
outcome, the status, the farthest vertex from the true ones in standard deviations, that of a fit which is
held near the true vertices (the floor), the volume over the true one, and the seconds of a processor.  The
outcomes, counted at the end, are

    right      within three floors, and no length is doubted,
    accused    the same, but a right length is named,
    named      the wrong length is the first that is named, by a doubt or a refusal,
    among      it is named among others,
    other      others are named, not this one,
    refused    no length is named,
    silent     converged without a doubt, and a length is wrong or the vertices are far.

By default one seed, two minutes.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

import isoembed
from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.errors import InvalidMetric, InvalidParameter
from rounded_truth import farthest, least_squares_surface

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import zoo
from sharp_bodies import BODIES

NEAR = 3.0  # floors


def volume(x, faces):
    a, b, c = x[faces].transpose(1, 0, 2)
    return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6


def drawn(exact, lengths, change, rng):
    """An edge whose wrong length, longer or shorter, breaks no triangle inequality, and the sign."""
    beside = exact.triangulation.edge_halfedges // 3
    while True:
        e, sign = int(rng.integers(len(lengths))), rng.choice([-1, 1])
        changed = lengths.copy()
        changed[e] += sign * change
        with_it = np.sort(changed[exact.triangulation.face_edges[beside[e]]])
        if (with_it[:, 2] < 0.95 * (with_it[:, 0] + with_it[:, 1])).all():
            return e, sign


def tried(name, error, blunder, seed):
    """One body: its outcome, and a line about it."""
    x, faces = BODIES[name](seed)
    x = x @ zoo.rotation(seed)
    exact = PolyhedralMetric.from_mesh(x, faces)
    sigma = error * exact.mean_length
    rng = np.random.default_rng([seed, 5])
    lengths = exact.lengths + sigma * rng.standard_normal(len(exact.lengths))
    wrong, sign = drawn(exact, lengths, blunder * sigma, rng)
    lengths[wrong] += sign * blunder * sigma
    began = time.process_time()
    try:
        found = embed(exact.with_lengths(lengths), length_errors=sigma)
    except NotEmbedded as failure:
        found = failure.embedding
    except (InvalidMetric, InvalidParameter) as failure:
        return "refused", f"{failure}"
    seconds = time.process_time() - began
    floor = farthest(
        least_squares_surface(
            exact.edges, np.where(np.arange(len(lengths)) == wrong, exact.lengths, lengths), x, sigma
        ),
        x,
    )
    off = farthest(found.vertices, x)
    measured = isoembed.report(found).get("measured", {"suspects": [], "other_suspects": []})
    told = [tuple(each["edge"]) for each in measured["suspects"]]
    alike = [tuple(each) for each in measured["other_suspects"]]
    edge = tuple(exact.edges[wrong].tolist())
    if not blunder:
        outcome = "silent" if off > NEAR * floor else "right"
        if told:
            outcome = "accused" if outcome == "right" else "other"
        elif not found.converged:
            outcome = "refused"
    elif edge in told[:1]:
        outcome = "named"
    elif edge in told + alike:
        outcome = "among"
    elif told:
        outcome = "other"
    else:
        outcome = "silent" if found.converged else "refused"
    status = "converged" if found.converged else "refused"
    return outcome, (
        f"{name:16} {error:.0e} {blunder:3.0f} {seed:4} {outcome:8} {status} {off / sigma:8.1f} "
        f"{floor / sigma:6.1f} {volume(found.vertices, faces) / volume(x, faces):.3f} {seconds:5.1f} s"
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", nargs="*", default=list(BODIES))
    parser.add_argument("--errors", nargs="*", type=float, default=[1e-3])
    parser.add_argument("--blunders", nargs="*", type=float, default=[0.0, 20.0, 35.0, 50.0])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    for blunder in options.blunders:
        count, total = Counter(), time.process_time()
        for error in options.errors:
            for name in options.bodies:
                for seed in range(options.first, options.first + options.seeds):
                    outcome, line_ = tried(name, error, blunder, seed + int(7 * blunder))
                    count[outcome] += 1
                    print(line_, flush=True)
        print(f"B {blunder:.0f}: {dict(count)} {time.process_time() - total:.0f} s", flush=True)


if __name__ == "__main__":
    main()
