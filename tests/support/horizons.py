"""Horizon files, written from known horizons, and what is found in them."""

from pathlib import Path

import numpy as np

from isoembed.relativity import KerrNewmanHorizon, KerrSchild
from isoembed.smooth import GridMetric

IMC = {0.5: 24.300446945608874, 0.6: 23.898597646410372}
AXES = ("+z", "+x", "+y", "-x", "-y", "-z")


def shape_text(radius, center=(0.0, 0.0, 0.0), n=13):
    """A shape file as AHFinderDirect writes it: six patches of n x n points."""
    angles = np.linspace(-45.0, 45.0, n)
    slope = np.tan(np.radians(angles))
    lines = ["# N_patches = 6", "# origin = " + " ".join(map(repr, center)), ""]
    for name in AXES:
        axis, side = "xyz".index(name[1]), 1.0 if name[0] == "+" else -1.0
        j, k = (i for i in range(3) if i != axis)
        u = np.empty((n, n, 3))
        u[..., axis], u[..., j], u[..., k] = side, slope[None, :], slope[:, None]
        u /= np.linalg.norm(u, axis=2, keepdims=True)
        r = radius(u.reshape(-1, 3)).reshape(n, n)
        lines += [f"### {name} patch", f"# N_rho = {n}", f"# N_sigma = {n}"]
        lines += ["# ghosted_gfn=-3", "# dpx = dsigma", "# dpy = drho", "#", "# dpx dpy gridfn x y z"]
        for i in range(n):
            for m in range(n):
                x, y, z = np.array(center) + r[i, m] * u[i, m]
                lines.append(
                    f"{angles[m]:.6g}\t{angles[i]:.6g}\t{r[i, m]:.15g}\t{x:.15g}\t{y:.15g}\t{z:.15g}"
                )
            lines.append("")
        lines.append("")
    return "\n".join(lines)


def write_kerr(name, spin):
    """The horizon of a Kerr black hole of mass 1 in Kerr-Schild coordinates."""
    geometry = KerrSchild(1.0, spin)
    Path(name).write_text(shape_text(geometry.spheroid(geometry.horizon)))


def write_grid(name, a):
    metric = GridMetric.sampled(KerrNewmanHorizon(1.0, a), 32, 1)
    np.savez(name, **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})


def check(found, a, largest=1e-6):
    """A Kerr horizon, within its errors."""
    r = 1.0 + np.sqrt(1.0 - a**2)
    area = 4.0 * np.pi * (r**2 + a**2)
    for name, exact in (
        ("area", area),
        ("integrated_mean_curvature", IMC[a]),
        ("irreducible_mass", np.sqrt(area / (16.0 * np.pi))),
        ("hawking", np.sqrt(area / (16.0 * np.pi))),
        ("liu_yau", IMC[a] / (4.0 * np.pi)),
    ):
        assert abs(found[name] - exact) <= found["errors"][name] <= largest * exact
