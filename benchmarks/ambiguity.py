"""Whether other surfaces with the same lengths are found, enumerated from what the default method returns.

    python benchmarks/ambiguity.py [--sizes N ...] [--bodies NAME ...] [--seeds N ...] [--motions K]
                                   [--distance D] [--surfaces N] [--whole]

Twelve bodies, each in ten triangulations: the regular one, and irregular ones.  The lengths are taken, the
vertices discarded.  What the default method returns is *same*, to 1e-6 mean edge lengths, *other*, another
realization, or *none*.  From other and none, the best attempt, the realizations nearby are enumerated as
`isoembed.realizations` does, until the discarded surface is among them; with --whole, to the end.

A line for each of these: how far the discarded surface is, how many realizations were found, from how many
they were searched, factorizations, seconds of the processor.  Any two realizations must be apart by the
isolation of their certificates.  Last comes a line a body, and how many of the discarded surfaces were found.
"""

import argparse
import time
from collections import Counter

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.aim.realization_search import RealizationSearch
from isoembed.gallery import Drum, Ellipsoid, Ergosphere, KerrHorizon, Superellipsoid, triangulate
from isoembed.progress.stages import Log
from isoembed.proof.certificate import certify
from isoembed.surface.alignment import distance
from isoembed.surface.rigidity import LengthSystem
from realizations import GALLERY

BODIES = {
    "kerr": KerrHorizon(spin=0.8),
    "drum": Drum(),
    "ellipsoid": Ellipsoid(),
    "superellipsoid": Superellipsoid(),
    **{name: GALLERY[name] for name in ("peanut", "bean", "tube")},
    **{f"ergosphere {epsilon}": Ergosphere(epsilon=epsilon) for epsilon in (0.3, 0.1, 0.02)},
    **{name: GALLERY[name] for name in ("saddle", "trefoil")},
}
SAME = 1e-6  # mean edge lengths
OUTCOMES = ("same", "other", "none")
CHECKED = 8  # realizations that are certified, of those that were found


def returned(metric):
    """What the default method returns, or its best attempt."""
    try:
        return embed(metric)
    except NotEmbedded as failure:
        return failure.embedding


def enumerated(surface, discarded, options):
    """Search from a surface; the search, whether it met the discarded vertices, and its factorizations."""
    metric, normalized = surface.metric, surface.metric.normalized
    with Log().stage("realizations") as recorder:
        search = RealizationSearch(
            normalized,
            LengthSystem(metric.triangulation, work=recorder.work),
            surface.vertices / metric.unit,
            recorder,
            options.motions,
            options.distance,
        )
        met = False
        for _ in search.steps(options.surfaces):
            met = met or any(
                distance(found, discarded / metric.unit) < SAME * normalized.mean_length
                for found in search.found
            )
            if met and not options.whole:
                break
    return search, met, recorder.factorizations


def check_apart(metric, search):
    """Some of the realizations are certified, and all others are farther than their isolations."""
    unit = metric.normalized.mean_length
    for i, found in enumerate(search.found[:CHECKED]):
        proof = certify(metric, metric.unit * found)
        if not proof.certified:
            print(f"    {proof.reason}")
            continue
        apart = min(
            (distance(found, other) / unit for j, other in enumerate(search.found) if j != i), default=np.inf
        )
        assert apart >= proof.isolation, f"{apart} apart, and isolated to {proof.isolation}"


def main():
    """Print the survey."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=[400, 1000], metavar="N")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=list(BODIES), metavar="NAME")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(10)), help="0 is regular")
    parser.add_argument("--motions", type=int, default=5)
    parser.add_argument("--distance", type=float, default=0.12)
    parser.add_argument("--surfaces", type=int, default=8)
    parser.add_argument("--whole", action="store_true")
    options = parser.parse_args()
    lines, found, sought = [], 0, 0
    for n in options.sizes:
        for name in options.bodies:
            count, met = Counter(), Counter()
            for seed in options.seeds:
                vertices, faces = triangulate(BODIES[name], n, irregular=seed or None)
                metric = PolyhedralMetric.from_mesh(vertices, faces)
                surface = returned(metric)
                away = distance(surface.vertices, vertices) / metric.mean_length
                outcome = "none" if not surface.converged else "same" if away < SAME else "other"
                count[outcome] += 1
                if outcome == "same":
                    continue
                start = time.process_time()
                search, is_met, factorizations = enumerated(surface, vertices, options)
                seconds = time.process_time() - start
                check_apart(metric, search)
                met[outcome] += is_met
                print(
                    f"{name:16} {n:6d} seed {seed}  {outcome:5} {away:.4f} away: "
                    f"{'found' if is_met else 'NOT FOUND'} among {len(search.found)}, searched from "
                    f"{sum(search.searched)}, {factorizations} factorizations, {seconds:.0f} s",
                    flush=True,
                )
            lines.append(
                f"{name:16} {n:6d}  {' / '.join(str(count[each]) for each in OUTCOMES):>12}  "
                f"found {met['other']} of {count['other']} other, {met['none']} of {count['none']} none"
            )
            found, sought = found + met.total(), sought + count["other"] + count["none"]
    print("\n".join(["", f"{'':16} {'':6}  same / other / none", *lines]))
    print(f"{found} of {sought}")


if __name__ == "__main__":
    main()
