"""Results of a run, with surfaces of a closed form."""

import numpy as np

import zoo
from isoembed.runs import Result
from isoembed.smooth import Harmonics

NUMBERS = ("irreducible_mass", "christodoulou_mass", "dimensionless_spin", "hawking", "brown_york")
HARMONICS = Harmonics(2, 2)


def moment(series, iteration, time):
    shape = f"h.t{iteration}.{series}.gp"
    return {"series": series, "time": time, "iteration": iteration, "shape": shape, "slice": None}


def embedded(series, iteration, time, *, half_axes=(1.0, 1.0, 1.0), turned=None, center=None, level=1):
    """An ellipsoid that was embedded; its mesh has 10 * 4^level + 2 vertices."""
    turned = np.eye(3) if turned is None else turned
    directions, faces = zoo.icosphere(level)
    stretch = np.diag(half_axes) @ turned.T
    u = zoo.icosphere(2)[0]
    basis = HARMONICS.derivatives(u, np.eye(HARMONICS.size))[0]
    coefficients = np.linalg.lstsq(basis, u @ stretch, rcond=None)[0]
    vertices = directions @ stretch
    values = {name: 0.5 + 0.01 * time * (k + 1) for k, name in enumerate(NUMBERS)}
    values |= {"area": 12.5, "integrated_mean_curvature": 12.0, "liu_yau": 1.0 / 3.0 + time}
    horizon = {} if center is None else {"center": list(center), "mean_coordinate_radius": 0.5}
    report = {
        "status": "embedded",
        "name": f"h.t{iteration}.{series}.gp",
        **values,
        "errors": dict.fromkeys(values, 1e-9),
        "notes": [],
        "spin": {"J": 0.1 * time, "error": 1e-7, "axis": [0.6, 0.0, 0.8], "axis_error": 1e-6},
        "space": {"name": "hyperbolic", "curvature": -0.1},
        "embedding": {"degree": 2, "order": 2, "residual": 1.0 / 7.0},
        "horizon": horizon,
        "moment": moment(series, iteration, time),
    }
    arrays = {
        "vertices": vertices,
        "faces": faces,
        "field/mean_curvature": 1.0 / np.linalg.norm(vertices, axis=1),
        "field/residual": np.full(len(vertices), 1e-9),
        "surface/coefficients": coefficients,
        "surface/degrees": np.array([HARMONICS.degree, HARMONICS.order]),
    }
    if center is not None:
        arrays["field/slice_coordinates"] = 0.5 * directions + center
    return Result(f"{series}.t{iteration}", "embedded", report, arrays)


def missing(series, iteration, time, status, message):
    """A horizon without an embedding."""
    facts = {"moment": moment(series, iteration, time), "name": f"h.t{iteration}.{series}.gp"}
    if status == "not embedded":
        facts |= {"area": 12.5, "errors": {"area": 1e-9}, "spin": None, "horizon": {}}
    return Result.without_answer(f"{series}.t{iteration}", status, message, **facts)
