"""Shape files as AHFinderDirect writes them, of surfaces that are known."""

import numpy as np

ORIGIN = np.array([3.25, 0.0, -0.5])

AXES = ("+z", "+x", "+y", "-x", "-y", "-z")


def lopsided(u):
    """No symmetry at all."""
    return 0.7 + 0.1 * u @ [0.3, -0.5, 0.6] + 0.08 * u[:, 0] * u[:, 2]


def nodes(axis, side, n, ghosts, half):
    """The angles and directions of one patch; `half` maps an axis to the sign of the half that is there."""
    steps = np.arange(-ghosts, n + ghosts)
    angles = np.radians(-45.0 + 90.0 / (n - 1) * steps)
    j, k = [i for i in range(3) if i != axis]
    ranges = []
    for i in (j, k):
        keep = np.ones(len(angles), dtype=bool)
        if i in half:
            reach = np.radians(90.0 / (n - 1) * ghosts) + 1e-9
            keep = half[i] * angles >= -reach
        ranges.append(angles[keep])
    u = np.zeros((len(ranges[1]), len(ranges[0]), 3))
    u[..., axis] = side
    u[..., j] = np.tan(ranges[0])[None, :]
    u[..., k] = np.tan(ranges[1])[:, None]
    return ranges, u / np.linalg.norm(u, axis=2, keepdims=True)


def shape_text(radius, n=9, ghosts=0, half=None, origin=ORIGIN, only=None):
    """A file as AHFinderDirect writes it."""
    half = half or {}
    names = [
        name
        for name in AXES
        if half.get("xyz".index(name[1]), 1 if name[0] == "+" else -1) == (1 if name[0] == "+" else -1)
    ]
    names = names if only is None else only
    lines = [f"# N_patches = {len(names)}", "# origin = " + " ".join(f"{x:.12g}" for x in origin), ""]
    for name in names:
        axis, side = "xyz".index(name[1]), 1 if name[0] == "+" else -1
        (a, b), u = nodes(axis, side, n, ghosts, half)
        trimmed = [len(r) - ghosts * 2 for r in (b, a)]
        lines += [f"### {name} patch", f"# N_rho = {trimmed[0]}", f"# N_sigma = {trimmed[1]}"]
        lines += ["# ghosted_gfn=-3", "# dpx = dsigma", "# dpy = drho", "#"]
        lines += ["# dpx\tdpy\tgridfn\tglobal_x\tglobal_y\tglobal_z"]
        r = radius(u.reshape(-1, 3)).reshape(u.shape[:2])
        for i, angle in enumerate(np.degrees(b)):
            for k, other in enumerate(np.degrees(a)):
                x = origin + r[i, k] * u[i, k]
                lines.append(
                    f"{other:.6g}\t{angle:.6g}\t{r[i, k]:#.15g}\t" + "\t".join(f"{c:#.10g}" for c in x)
                )
            lines.append("")
        lines.append("")
    return "\n".join(lines)


def diagnostics_text(rows):
    """A table BH_diagnostics of AHFinderDirect, of rows of iteration, time and area."""
    head = [f"# column  {k} = {name}" for k, name in enumerate(("cctk_iteration", "cctk_time", "area"), 1)]
    return "\n".join(["# apparent horizon 1/1", "#", *head, *("\t".join(map(str, row)) for row in rows), ""])
