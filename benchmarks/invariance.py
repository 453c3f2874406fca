"""Relabeling and rescaling: do they change what is found?

    python benchmarks/invariance.py [--method NAME] [--seeds N] [--families NAME ...] [--json FILE]

Metrics of the convex sweep (`convex_families`), a hundred of each family by default, are embedded as they are
and once more with vertices and faces in another order, each face from another corner, and all lengths times
a random number from 1e-8 to 1e8, which rounds them.  Both answers have to be of the same status, and surfaces
the same to 1e-8 of the diameter.  A method that keeps the given triangles gets the metrics whose triangles
are a simplicial complex.  Where rounding of the lengths may move the vertices that far (`uncertainty`, flat
bodies, and noise), surfaces that differ are counted apart.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

import convex_check
import convex_families
from convex_sweep import metric_of

SAME = 1e-8  # of the diameter


def relabeled(case, rng):
    """The same metric with other numbers, in another unit; the new numbers of vertices; and the unit."""
    new, unit = rng.permutation(case.faces.max() + 1), 10 ** rng.uniform(-8, 8)
    place, turn = rng.permutation(len(case.faces)), rng.integers(3, size=len(case.faces))
    halfedge = 3 * place[:, None] + (np.arange(3) - turn[:, None]) % 3  # of the old face and corner
    faces, lengths = np.empty(case.faces.size, dtype=np.int64), np.empty(case.faces.size)
    faces[halfedge], lengths[halfedge] = new[case.faces], case.lengths * unit
    twins = None
    if case.twins is not None:
        twins = np.empty_like(case.twins)
        twins[halfedge.ravel()] = halfedge.ravel()[case.twins]
    copy = replace(case, faces=faces.reshape(-1, 3), twins=twins, lengths=lengths.reshape(-1, 3))
    return copy, new, unit


def answer(case, method):
    """Vertices, or the reason why there are none."""
    import isoembed

    try:
        chosen = isoembed.Alexandrov(repair=case.repair) if case.repair else method
        return isoembed.embed(metric_of(case), method=chosen).vertices
    except (isoembed.NotEmbedded, isoembed.InvalidMetric) as refusal:
        return f"{type(refusal).__name__}: {refusal}"


def compared(family, number, method, glued):
    """Embed a metric and its copy: a row, or None if the method does not take the metric."""
    case = convex_families.make(family, number)
    if not glued and (case.twins is not None or len(case.faces) == 2 or case.repair):
        return None
    copy, new, unit = relabeled(case, np.random.default_rng([number, *family.encode()]))
    first, second = answer(case, method), answer(copy, method)
    row = {"family": family, "number": number, "size": case.size, "vertices": len(new)}
    refusals = [a for a in (first, second) if isinstance(a, str)]
    if len(refusals) == 2:
        return row | {"came": "both refused"}
    if refusals:
        which = "the copy" if isinstance(second, str) else "the original"
        return row | {"came": "status", "message": f"{which}: {refusals[0]}"}
    off = convex_check.distance(second[new] / unit, first)
    if off <= SAME:
        return row | {"came": "same", "distance": off}
    unsure = np.inf if case.repair else convex_check.uncertainty(case)
    came = "surface" if unsure <= SAME else "undetermined"
    return row | {"came": came, "distance": off, "message": f"{off:.1e} apart, uncertain by {unsure:.1e}"}


def main():
    """Run what is asked."""
    from isoembed._embed import configured

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--method", default="alexandrov")
    parser.add_argument("--seeds", type=int, default=100, metavar="N", help="metrics of every family")
    parser.add_argument("--families", nargs="*", default=list(convex_families.FAMILIES), metavar="NAME")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all rows")
    options = parser.parse_args()
    glued = configured(options.method).takes_glued
    kinds, rows = ("same", "both refused", "undetermined", "status", "surface"), []
    print(f"{'family':24}", *(f"{kind:>{max(6, len(kind))}}" for kind in kinds))
    for family in options.families:
        with threadpool_limits(1):
            some = [compared(family, number, options.method, glued) for number in range(options.seeds)]
        some = [row for row in some if row]
        came = [row["came"] for row in some]
        counts = (f"{came.count(kind):{max(6, len(kind))}d}" for kind in kinds)
        print(f"{family:24}", *counts, flush=True)
        rows += some
    differ = [row for row in rows if row["came"] in ("status", "surface")]
    for row in differ:
        print(row["family"], row["number"], row["came"], row["message"])
    print(f"{len(rows)} metrics, {len(differ)} with another status or surface (asked: 0)")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=0))


if __name__ == "__main__":
    main()
