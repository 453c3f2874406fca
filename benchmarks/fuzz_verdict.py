"""What comes of a metric in the fuzzer: it is embedded twice, and everything is checked."""

import time
import traceback
import warnings
from dataclasses import replace

import numpy as np

import convex_check
import fuzz_check
import fuzz_families
import isoembed
from convex_cases import relabeled
from convex_sweep import judged, metric_of
from isoembed import Alexandrov
from isoembed.alexandrov.polyhedron import metric_on
from isoembed.proof.certificate import certify
from isoembed.proof.convex import certify as certify_convex

KINDS = ("found", "another", "refused", "lost", "FALSE", "differ", "exception", "warning", "hang", "crash")
KEPT = KINDS[4:]
CERTIFIED = 60  # vertices of the largest surface whose certificate is asked for
SAME = 1e-8  # of the diameter: the two answers
UNSURE = 1e-8  # mean edge lengths: of a realization, where nothing is proven
SAME_SURFACE = 1e-6  # of the diameter: an answer and the discarded coordinates


def asked(case, family, seed):
    """The method for this case."""
    method = fuzz_families.METHODS[family]
    if case.repair:
        return Alexandrov(repair=case.repair)
    own = case.twins is None and len(case.faces) > 2
    return "aim" if method == "aim" or (own and seed % 4 == 3 and family != "not convex") else method


def answer(case, method):
    """The embedding, or the sentence of the refusal."""
    try:
        return isoembed.embed(metric_of(case), method=method)
    except (isoembed.NotEmbedded, isoembed.InvalidMetric) as refusal:
        if "\n" in str(refusal) or not str(refusal):
            raise RuntimeError("the refusal is not one sentence") from refusal
        return f"{type(refusal).__name__}: {refusal}"


def run(case, family, seed):
    """Embed a case and its copy and judge both: a row."""
    method = asked(case, family, seed)
    name = method if isinstance(method, str) else method.name
    row = {"family": family, "seed": seed, "method": name, "vertices": int(case.faces.max()) + 1}
    row |= {"size": case.size, "name": case.name}
    start = time.process_time()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            row |= verdict(case, method, fuzz_families.KNOWN[family], seed)
        except Exception as error:  # what the fuzzer looks for
            where = traceback.extract_tb(error.__traceback__)[-1]
            row |= {"kind": "exception", "message": f"{error!r} at {where.filename}:{where.lineno}"}
    if said and row["kind"] not in KEPT:
        row |= {"kind": "warning", "message": f"{said[0].category.__name__}: {said[0].message}"}
    return row | {"seconds": time.process_time() - start}


def verdict(case, method, known, seed):
    """What came of a case."""
    found = answer(case, method)
    if known == fuzz_families.NONE and not isinstance(found, str):
        return {"kind": "FALSE", "message": "a metric that has no such surface was embedded"}
    first = {"kind": "refused", "message": found} if isinstance(found, str) else right(case, found)
    if first["kind"] == "refused" and known == fuzz_families.REALIZABLE:
        first["kind"] = "lost"
    if first["kind"] == "FALSE" or case.lengths.min() <= 0 or not np.isfinite(case.lengths).all():
        return first
    if case.faces.min() < 0 or len(np.unique(case.faces)) != case.faces.max() + 1:
        return first
    copy, new, unit = relabeled(case, np.random.default_rng([seed, 1]))
    second = answer(copy, method)
    if isinstance(found, str) and isinstance(second, str):
        return first
    if isinstance(found, str) or isinstance(second, str):
        which, why = ("original", found) if isinstance(found, str) else ("copy", second)
        return {"kind": "differ", "message": f"the {which}: {why}"}
    bad = wrong_lengths(second)
    if bad:
        return {"kind": "FALSE", "message": f"the copy: {bad}"}
    off = fuzz_check.apart(found.vertices, second.vertices[new] / unit, case.curvature)
    first["copy"] = off
    if off <= SAME or off <= 100 * uncertainty(case, found):
        return first
    kind = "differ" if known == fuzz_families.REALIZABLE and method == "alexandrov" else "another"
    return first | {"kind": kind, "message": f"the copy is {off:.1e} of the diameter away"}


def uncertainty(case, found):
    """How far the errors of its lengths may move a surface, over the diameter."""
    if case.repair:
        return np.inf
    if hasattr(found, "given"):
        body = case.core if case.curvature == 0 else (found.vertices, found.faces)
    else:
        body = found.vertices, found.faces
    return convex_check.uncertainty(replace(case, core=body), found, found.residual)


def right(case, found):
    """Whether an answer is a surface with these lengths, and which."""
    bad = wrong_lengths(found)
    if bad:
        return {"kind": "FALSE", "message": bad}
    if not hasattr(found, "given"):
        bad = wrong_claims(case, found)
    elif case.curvature == 0:
        row = judged(case, found)
        bad = "" if row["status"] == "found" else row["message"]
    else:
        excess = fuzz_check.outside_hull(found.vertices, found.faces, case.curvature)
        bad = "" if excess <= fuzz_check.OFF_HULL else f"off hull {excess:.1e}"
    if not bad and hasattr(found, "given") and not case.repair:
        length, aside = fuzz_check.path_error(found)
        if not (length <= fuzz_check.PATHS and aside <= fuzz_check.ASIDE):
            bad = f"unfolded paths {length:.1e}, {aside:.1e} beside what they cross"
    if bad:
        return {"kind": "FALSE", "message": bad}
    if case.points is None or case.repair:
        return {"kind": "found", "message": ""}
    if len(case.points) <= CERTIFIED:
        bad = wrong_certificate(found, case.points)
        if bad:
            return {"kind": "FALSE", "message": bad}
    off = fuzz_check.apart(found.vertices[: len(case.points)], case.points, case.curvature)
    if off <= SAME_SURFACE or off <= 100 * (unsure := uncertainty(case, found)):
        return {"kind": "found", "message": "", "distance": off}
    kind = "FALSE" if hasattr(found, "given") and np.isfinite(unsure) else "another"
    return {"kind": kind, "message": f"{off:.1e} of the diameter away", "distance": off}


def wrong_certificate(found, points):
    """What the discarded coordinates disprove of a certificate, or nothing.

    They have other lengths than the answer's metric, by rounding, and these differences are known: the answer
    is certified once more, for all lengths within them, and has to be as near to the coordinates as that
    says, or, if it need not be convex, as far.  Where nothing is proven of so different lengths, nothing is
    disproved.
    """
    if not isoembed.certify(found).certified:
        return ""
    if isoembed.certify(found).embedded:
        pair = fuzz_check.pierced(found.vertices, found.faces, found.metric.curvature)
        if pair:
            return f"certified, but edge {pair[0]} crosses face {pair[1]}"
    metric, vertices, convex = found.metric, found.vertices, hasattr(found, "given")
    if convex:
        tables, vertices = found.core
        metric, points = metric_on(tables), np.delete(points, found.flat_vertices, axis=0)
    k, (a, b) = metric.curvature, metric.edges.T
    errors = np.abs(fuzz_check.distances(points[a], points[b], k) - metric.lengths).astype(float)
    proof = (certify_convex if convex else certify)(metric, vertices, np.nextafter(errors, np.inf))
    if not proof.certified:
        return ""
    radius, far = proof.radius * metric.mean_length, proof.isolation * metric.mean_length
    gap = fuzz_check.gap(vertices, points, k)
    if gap <= 2 * radius:  # of two vertices, both moved
        return ""
    if not convex:
        if k:
            return ""
        weights = np.bincount(np.r_[a, b], np.tile(metric.lengths**-2.0, 2))
        off = fuzz_check.misfit(vertices, points, weights).max()
        if off >= far * (1 - 1e-9):
            return ""
    return f"{proof.reason}; but the distances of vertices are off by {gap:.1e}"


def wrong_lengths(found):
    """What is wrong with the lengths of the triangles that an answer has, or nothing."""
    k, metric = found.metric.curvature, found.metric
    for surface in (found, *found.others):
        off = fuzz_check.length_error(surface.vertices, metric.faces, metric.face_lengths, k)
        if not off <= fuzz_check.LENGTHS:
            return f"lengths off by {off:.1e} of the mean, where {surface.residual:.1e} was said"
    return ""


def are_two(found, other):
    """Whether two realizations are two: clearly, or by what is proven of how far both are from exact ones.

    Flat caps may be far apart and have much the same distances.
    """
    k, mean = found.metric.curvature, found.metric.mean_length
    if fuzz_check.apart(found.vertices, other.vertices, k) > SAME:
        return True
    if k:
        return False
    proofs = isoembed.certify(found), isoembed.certify(other)
    radii = [proof.radius if proof.certified else UNSURE for proof in proofs]
    off = fuzz_check.misfit(found.vertices, other.vertices, np.ones(len(found.vertices)))
    return np.sqrt(np.mean(off**2)) > mean * sum(radii)


def wrong_claims(case, found):
    """What is wrong with what an answer on the given triangles says of itself, or nothing."""
    if not (np.array_equal(found.faces, case.faces) and np.allclose(found.metric.face_lengths, case.lengths)):
        return "the triangles are not the given ones"
    for other in found.others:
        if not are_two(found, other):
            return "another realization is the same"
    unit = found.metric.unit
    if case.curvature == 0 and 1e-90 < unit < 1e90:  # or volumes are none that floats have
        a, b, c = (found.vertices[found.faces[:, k]] / unit for k in range(3))
        lengths = case.lengths / unit
        volume, areas = np.einsum("ij,ij->", a, np.cross(b, c)) / 6, convex_check.heron(lengths)
        if not abs(volume - found.volume / unit**3) <= 1e-9 * abs(volume) + 1e-9:
            return f"the volume is off by {volume - found.volume / unit**3:.1e} {unit:.1e}^3"
        # By how much the area changes with the lengths: those of slivers, much.
        p, q, r = (np.roll(lengths, k, axis=1) for k in range(3))
        slack = (p * np.abs(q * q + r * r - p * p) / (8 * areas.astype(float)[:, None])).sum()
        most = 2 * found.residual * found.metric.mean_length / unit * slack
        area, said = float(areas.sum()), found.area / unit**2
        if not abs(area - said) <= 1e-9 * area + most:
            return f"the area is off by {abs(area - said) / area:.1e}"
    return ""
