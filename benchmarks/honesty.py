"""Stated errors against true ones, on inputs whose energies are known.

    python benchmarks/honesty.py [--only KIND ...] [--seeds N] [--json FILE]

For each input the true relative error, the stated one and their ratio, of the energy whose ratio is the
largest.  What is true comes from closed forms and Gauss's quadrature in honesty_truth.py.  True errors below
1e-13 are rounding.  A refusal is an honest answer and is counted apart; so is a number that is left out.
Asked: no ratio above 3, fewer than 1 % above 1, and stated errors that are in the median less than 30 times
the true ones; where only the metric is uncertain, of nine in ten less than 1,000 times.
"""

import argparse
import json
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import honesty_grids
import honesty_hyperbolic
import honesty_surfaces
import honesty_triangles
from isoembed import InvalidMetric, InvalidParameter, NotEmbedded

ROUNDING = 1e-13
DISHONEST = 3.0
WORST = 10


@dataclass(frozen=True)
class Row:
    """One energy of one input; errors over the size of the integrals that it is made of."""

    kind: str
    name: str
    energy: str
    true: float
    stated: float
    metric_only: bool

    @property
    def ratio(self):
        """The true error over the stated one, 0 where there is only rounding."""
        if self.true <= ROUNDING:
            return 0.0
        return self.true / self.stated if self.stated > 0.0 else np.inf

    @property
    def excess(self):
        """The stated error over the true one, or over rounding."""
        return self.stated / max(self.true, ROUNDING)


def rows_of(case, found):
    """A row for each energy that is known and was found."""
    for energy in case.sought:
        truth, estimate = case.truth[energy], getattr(found, energy)
        if truth is None or estimate is None:
            continue
        size = abs(truth)
        if energy in ("hawking", "brown_york", "liu_yau"):  # differences, which may vanish
            size = max(size, case.truth["integrated_mean_curvature"] / (4.0 * np.pi))
        yield Row(
            case.kind,
            case.name,
            energy,
            abs(estimate.value - truth) / size,
            estimate.error / size,
            case.metric_only,
        )


def missing(case, found):
    return [name for name in case.sought if case.truth[name] is not None and getattr(found, name) is None]


def summary(counts, rows):
    """The last lines."""
    ratios, excess = np.array([r.ratio for r in rows]), np.array([r.excess for r in rows])
    of_metric = np.array([r.metric_only for r in rows])
    high = sorted((r for r in rows if r.ratio > 1.0), key=lambda r: -r.ratio)
    print(f"\ninputs: {counts['inputs']}")
    print(f"refused: {counts['refused']}, numbers left out: {counts['missing']}")
    print(f"numbers: {len(rows)}")
    print(f"ratio above 3: {np.sum(ratios > DISHONEST)} (asked: 0)")
    print(f"ratio above 1: {100 * np.mean(ratios > 1.0):.2f} % (asked: < 1 %)")
    print(f"median of stated over true: {np.median(excess):.3g} (asked: < 30)")
    if of_metric.any():
        print(
            "90th percentile of stated over true where only the metric is uncertain: "
            f"{np.percentile(excess[of_metric], 90):.3g} (asked: < 1000)"
        )
    print(f"the worst {min(WORST, len(high))} of {len(high)} above 1:")
    for r in high[:WORST]:
        print(f"  {r.ratio:8.3g}  true {r.true:.1e}  stated {r.stated:.1e}  {r.energy}: {r.kind}, {r.name}")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", metavar="KIND", help="kinds of inputs")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="draws of what is random")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all rows")
    options = parser.parse_args()
    counts, rows, refusals = Counter(), [], Counter()
    for source in (honesty_grids, honesty_surfaces, honesty_triangles, honesty_hyperbolic):
        for case in source.cases(options.seeds):
            if options.only and case.kind not in options.only:
                continue
            counts["inputs"] += 1
            started = time.process_time()
            try:
                found = case.solve()
            except (InvalidMetric, InvalidParameter, NotEmbedded) as error:
                counts["refused"] += 1
                refusals[case.kind] += 1
                print(f"{case.kind:12} {case.name:60} refused: {error}", flush=True)
                continue
            some = list(rows_of(case, found))
            counts["missing"] += len(missing(case, found))
            rows += some
            worst = max(some, key=lambda r: (r.ratio, -r.excess))
            print(
                f"{case.kind:12} {case.name:60} {worst.energy:26} {worst.true:8.1e} {worst.stated:8.1e} "
                f"{worst.ratio:8.2g} {time.process_time() - started:6.1f} s",
                flush=True,
            )
    summary(counts, rows)
    print("refused, by kind:", dict(refusals))
    if options.json:
        found = [{**vars(r), "ratio": r.ratio, "excess": r.excess} for r in rows]
        options.json.write_text(json.dumps(found, indent=0))


if __name__ == "__main__":
    main()
