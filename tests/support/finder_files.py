"""Horizon files as BHaHAHA, GRChombo and SpECTRE write them, of surfaces r(u) about a center."""

import math

import numpy as np
from scipy.special import lpmv


def lopsided(u):
    """A radius without any symmetry, of degree 3."""
    x, y, z = u.T
    return 0.9 + 0.1 * x - 0.07 * y + 0.05 * z + 0.06 * x * z + 0.04 * x * y + 0.03 * x * y * z


def directions(theta, phi):
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def bhahaha_text(radius=lopsided, center=(3.25, -1.0, 0.5), time=1.25, n_theta=12, n_phi=20):
    """A shape file h.t*.ah*.gp of BHaHAHA."""
    lines = [f"# gnuplot-compatible horizon surface data, at time {time:.3f}."]
    lines += [f"# Column {k}: {axis} coordinate" for k, axis in enumerate("xyz", 1)]
    phi = -np.pi + (np.arange(n_phi) + 0.5) * (2.0 * np.pi / n_phi)
    for theta in (np.arange(n_theta) + 0.5) * np.pi / n_theta:
        u = directions(theta, phi)
        ring = ["{:.10e} {:.10e} {:.10e}".format(*x) for x in center + radius(u)[:, None] * u]
        lines += [*ring, ring[0], ""]
    return "\n".join(lines) + "\n"


def bhahaha_diagnostics(rows):
    """A table BHaHAHA_diagnostics.ah*.gp, of rows of iteration and time."""
    head = ["# apparent horizon 1/1", "#", "# column  1 = Current simulation iteration"]
    return "\n".join([*head, *(f"{k}\t{time:.3f}\t0.5\t0.0\t0.0" for k, time in rows), ""])


def grchombo_text(radius=lopsided, n_u=13, n_v=20, uniform=False, more=()):
    """A file coords_AH*_*.dat: theta runs fastest and has both poles; or even cos(theta), without poles."""
    u = -1.0 + (np.arange(n_u) + 0.5) * 2.0 / n_u if uniform else np.linspace(0.0, np.pi, n_u)
    names = ["z/r" if uniform else "theta", "phi", "r"]
    lines = ["#" + "".join(f"{name:>12}" for name in names)[1:] + "".join(f"{name:>20}" for name in more)]
    for phi in 2.0 * np.pi / n_v * np.arange(n_v):
        r = radius(directions(np.arccos(u) if uniform else u, phi))
        rest = f"{1.0:20.10e}" * len(more)
        lines += [f"{u[k]:12.7f}{phi:12.7f}{r[k]:12.7f}{rest}" for k in range(n_u)]
    return "\n".join(lines) + "\n"


def grchombo_stats(rows, tracked=True):
    """A table stats_AH*.dat, of rows of time, file number and origin."""
    names = ["file", "area", "mass", "irreducible mass", "spin", "linear mom. |P|"]
    names += [f"origin_{axis}" for axis in "xyz"] + [f"center_{axis}" for axis in "xyz" if tracked]
    lines = ["#" + f"{'time':>11}" + "".join(f"{name:>20}" for name in names)]
    for time, number, origin in rows:
        values = [number, np.nan, 0.5, 0.5, 0.0, 0.0, *origin, *([7.0, 8.0, 9.0] if tracked else [])]
        lines.append(f"{time:12.7f}" + "".join(f"{x:20.10e}" for x in values))
    return "\n".join(lines) + "\n"


def ylm_legend(degree, frame="Inertial"):
    centers = [f"{frame}ExpansionCenter_{axis}" for axis in "xyz"]
    coefficients = [f"coef({l},{m})" for l in range(degree + 1) for m in range(-l, l + 1)]
    return ["Time", *centers, "Lmax", *coefficients]


def ylm_row(time, center, radius=lopsided, degree=4, columns=4):
    """A row of a table *_Ylm.dat with room for the degree `columns`.

    By the definition in SpECTRE's documentation: (-1)^m sqrt(2 / pi) times the real and, for m < 0, the
    imaginary part of the coefficients of the complex harmonics with the Condon-Shortley phase.
    """
    z, weights = np.polynomial.legendre.leggauss(2 * degree + 2)
    phi = 2.0 * np.pi / (4 * degree + 4) * np.arange(4 * degree + 4)
    r = radius(directions(np.arccos(z)[:, None], phi).reshape(-1, 3)).reshape(len(z), len(phi))
    row = [time, *center, degree]
    for l in range(columns + 1):
        for m in range(-l, l + 1):
            k = abs(m)
            norm = math.sqrt((2 * l + 1) / (4.0 * math.pi) * math.factorial(l - k) / math.factorial(l + k))
            conjugate = norm * lpmv(k, l, z)[:, None] * np.exp(-1j * k * phi)
            F = np.sum(weights[:, None] * r * conjugate) * (phi[1] - phi[0])
            part = F.real if m >= 0 else F.imag
            row.append((-1) ** k * math.sqrt(2.0 / math.pi) * part if l <= degree else 0.0)
    return row


def ylm_text(rows, legend):
    """A table as `spectre extract-dat` writes it."""
    head = [f"# [{k}] {name}" for k, name in enumerate(legend)]
    return "\n".join([*head, *(" ".join(f"{x:.16e}" for x in row) for row in rows), ""])


def write_ylm(path, tables):
    """An HDF5 file of tables, each of rows and a legend."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, (rows, legend) in tables.items():
            data = file.create_dataset(name, data=np.array(rows), maxshape=(None, len(legend)))
            data.attrs["Legend"] = legend
    return path
