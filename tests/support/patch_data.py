"""Files as GRChombo, AMReX's codes and AthenaK write them, of slices in closed form on refinement levels."""

import struct
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SIX = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
LETTERS = ("xx", "xy", "xz", "yy", "yz", "zz")
NUMBERS = ("11", "12", "13", "22", "23", "33")
STALE = 1e3  # what ghost zones hold, which must not be read


@dataclass(frozen=True)
class Grid:
    """Cells of a domain, and boxes of them that are refined by two, one level in the other.

    Attributes
    ----------
    low : tuple of floats
        The lower corner of the domain.
    spacing : float
        Of the coarsest level.
    boxes : tuple of tuples of (tuple of int, tuple of int)
        Of each level: first cells, and numbers of cells.
    center : tuple of floats
        Where the hole is.
    excised : float
        Radius of the sphere around it without data.
    """

    low: tuple
    spacing: float
    boxes: tuple
    center: tuple = (0.0, 0.0, 0.0)
    excised: float = 0.5

    def points(self, level, start, shape, shift=0.5):
        """Points (nx, ny, nz, 3) of a box."""
        h = self.spacing / 2**level
        axes = [
            low + h * (np.arange(n) + s + shift) for low, s, n in zip(self.low, start, shape, strict=True)
        ]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@lru_cache(maxsize=512)
def fields(geometry, points):
    """gamma_ij and K_ij (n, 3, 3) at points (n, 3) given as bytes; many files have the same."""
    x = np.frombuffer(points).reshape(-1, 3)
    return geometry.metric(x), geometry.extrinsic_curvature(x)


def adm(geometry, grid, points):
    """gamma_ij and K_ij (nx, ny, nz, 3, 3); flat where the hole is excised."""
    x = points.reshape(-1, 3) - np.array(grid.center)
    there = np.linalg.norm(x, axis=1) > grid.excised
    gamma, curvature = np.tile(np.eye(3), (len(x), 1, 1)), np.zeros((len(x), 3, 3))
    gamma[there], curvature[there] = fields(geometry, x[there].tobytes())
    return (each.reshape(*points.shape[:-1], 3, 3) for each in (gamma, curvature))


def conformal(gamma, curvature):
    """chi = det(gamma)^(-1/3), h_ij, A_ij and K."""
    chi = np.linalg.det(gamma) ** (-1 / 3)
    trace = np.einsum("...ij,...ij", np.linalg.inv(gamma), curvature)
    h = chi[..., None, None] * gamma
    a = chi[..., None, None] * (curvature - trace[..., None, None] * gamma / 3)
    return chi, h, a, trace


def grchombo(geometry, grid, points):
    """The variables of GRChombo and GRTeclyn by name."""
    chi, h, a, trace = conformal(*adm(geometry, grid, points))
    out = {"chi": chi}
    out |= {f"h{n}": h[..., i, j] for n, (i, j) in zip(NUMBERS, SIX, strict=True)}
    out |= {"K": trace} | {f"A{n}": a[..., i, j] for n, (i, j) in zip(NUMBERS, SIX, strict=True)}
    return out | {"Theta": np.full_like(chi, 7.0), "lapse": np.ones_like(chi)}


def plain(geometry, grid, points, metric="g", curvature="k"):
    """The ADM variables by name."""
    gamma, k = adm(geometry, grid, points)
    return {f"{metric}{n}": gamma[..., i, j] for n, (i, j) in zip(LETTERS, SIX, strict=True)} | {
        f"{curvature}{n}": k[..., i, j] for n, (i, j) in zip(LETTERS, SIX, strict=True)
    }


def athenak_adm(geometry, grid, points):
    """The output variable ``adm`` of AthenaK."""
    return plain(geometry, grid, points, "adm_g", "adm_K")


def z4c(power, theta=0.01):
    """The output variable ``z4c`` of AthenaK, chi being such a power of psi; Theta a constant."""

    def variables(geometry, grid, points):
        chi, h, a, trace = conformal(*adm(geometry, grid, points))
        out = {"z4c_chi": chi ** (-power / 4)}
        out |= {f"z4c_g{n}": h[..., i, j] for n, (i, j) in zip(LETTERS, SIX, strict=True)}
        out |= {"z4c_Khat": trace - 2 * theta}
        out |= {f"z4c_A{n}": a[..., i, j] for n, (i, j) in zip(LETTERS, SIX, strict=True)}
        return out | {"z4c_Theta": np.full_like(chi, theta)}

    return variables


def grown(geometry, grid, variables, level, box, ghosts, shift=0.5):
    """Variables on a box with ghost zones: names, and values (n, nz, ny, nx), x running fastest."""
    start, shape = box
    inside = tuple(slice(ghosts, ghosts + n) for n in shape)
    out, values = {}, variables(geometry, grid, grid.points(level, start, shape, shift))
    for name, array in values.items():
        out[name] = np.full([n + 2 * ghosts for n in shape], STALE)
        out[name][inside] = array
    return list(out), np.stack([array.T for array in out.values()])


def mirrored(names, values, box, ghosts, axis):
    """Fill the ghost zones of a box at a mirror, x_axis = 0, as reflective boundaries do."""
    if box[0][axis] == 0:
        along = np.moveaxis(values, 3 - axis, -1)
        odd = [name[0] in "hA" and name.count(str(axis + 1)) == 1 for name in names]
        signs = np.where(odd, -1.0, 1.0)[:, None, None, None]
        along[..., :ghosts] = signs * along[..., 2 * ghosts - 1 : ghosts - 1 : -1]


def write_chombo(
    path, geometry, grid, variables=grchombo, *, ghosts=3, mirrors=(), dimensions=3, time=0.0, iteration=0
):
    """A checkpoint or plot file; at mirrors the ghost zones are copies of the cells inside."""
    import h5py

    vector = np.dtype([(f"intvect{a}", "<i4") for a in "ijk"])
    corners = np.dtype([(f"{end}_{a}", "<i4") for end in ("lo", "hi") for a in "ijk"])
    with h5py.File(path, "w") as file:
        file.create_group("Chombo_global").attrs.update({"SpaceDim": dimensions, "testReal": 0.0})
        file.attrs.update(
            {"num_levels": len(grid.boxes), "max_level": 9, "iteration": iteration, "time": time}
        )
        for level, boxes in enumerate(grid.boxes):
            group = file.create_group(f"level_{level}")
            group.attrs.update({"dx": grid.spacing / 2**level, "ref_ratio": 2, "time": time})
            ends = [(*start, *(np.array(start) + shape - 1)) for start, shape in boxes]
            group["boxes"] = np.array(ends, dtype=corners)
            low, high = np.min(ends, axis=0)[:3], np.max(ends, axis=0)[3:]
            group.attrs["prob_domain"] = np.array((*low, *high), dtype=corners)
            parts = [grown(geometry, grid, variables, level, box, ghosts) for box in boxes]
            for (names, values), box in zip(parts, boxes, strict=True):
                for axis in mirrors:
                    mirrored(names, values, box, ghosts, axis)
            names = parts[0][0]
            group["data:datatype=0"] = np.concatenate([values.ravel() for _, values in parts])
            group["data:offsets=0"] = np.cumsum([0, *(values.size for _, values in parts)])
            attributes = group.create_group("data_attributes").attrs
            attributes.update({"comps": len(names), "outputGhost": np.array((ghosts,) * 3, vector)})
        file.attrs["num_components"] = len(names)
        for k, name in enumerate(names):
            file.attrs[f"component_{k}"] = np.bytes_(name)


def text(box, kind=0):
    """A box as AMReX writes it."""
    start, shape = box
    ends = (start, [s + n - 1 for s, n in zip(start, shape, strict=True)], [kind] * 3)
    return f"({' '.join('(' + ','.join(map(str, end)) + ')' for end in ends)})"


def write_amrex(
    folder, geometry, grid, variables=grchombo, *, ghosts=0, nodal=False, real="<f8", time=0.0, iteration=0
):
    """A plot file."""
    order = {"<": range(8, 0, -1), ">": range(1, 9)}[real[0]]
    order = [k for k in order if k <= int(real[2])]
    kind = {"8": "64 11 52 0 1 12 0 1023", "4": "32 8 23 0 1 9 0 127"}[real[2]]
    number, last = int(nodal), len(grid.boxes) - 1
    domain = np.max([np.add(*box) for box in grid.boxes[0]], axis=0).tolist()
    header, levels = [], []
    for level, boxes in enumerate(grid.boxes):
        inside = folder / f"Level_{level}"
        inside.mkdir(parents=True)
        places = []
        with (inside / "Cell_D_00000").open("wb") as file:
            for start, shape in boxes:
                box = start, [n + number for n in shape]
                names, values = grown(geometry, grid, variables, level, box, ghosts, 0.0 if nodal else 0.5)
                places.append(f"FabOnDisk: Cell_D_00000 {file.tell()}")
                wide = [s - ghosts for s in start], [n + 2 * ghosts for n in box[1]]
                file.write(
                    f"FAB (({real[2]}, ({kind})),({real[2]}, ({' '.join(map(str, order))})))"
                    f"{text(wide, number)} {len(names)}\n".encode()
                )
                file.write(values.astype(real).tobytes())
        written = [text((start, [n + number for n in shape]), number) for start, shape in boxes]
        rows = [f"({len(boxes)} 0", *written, ")", str(len(boxes)), *places, ""]
        (inside / "Cell_H").write_text("\n".join(["1", "1", str(len(names)), str(ghosts), *rows]))
        h = grid.spacing / 2**level
        levels += [f"{level} {len(boxes)} {time}", str(iteration)]
        for start, shape in boxes:
            levels += [
                f"{low + h * s} {low + h * (s + n)}" for low, s, n in zip(grid.low, start, shape, strict=True)
            ]
        levels.append(f"Level_{level}/Cell")
    high = [low + grid.spacing * n for low, n in zip(grid.low, domain, strict=True)]
    domains = [text(([0, 0, 0], [n * 2**level for n in domain])) for level in range(last + 1)]
    header = [
        "HyperCLaw-V1.1",
        str(len(names)),
        *names,
        "3",
        repr(time),
        str(last),
        " ".join(map(str, grid.low)) + " ",
        " ".join(map(str, high)) + " ",
        "2 " * last,
        " ".join(domains) + " ",
        f"{iteration} " * (last + 1),
        *(" ".join([repr(grid.spacing / 2**level)] * 3) + " " for level in range(last + 1)),
        "0",
        "0",
        *levels,
        "",
    ]
    (folder / "Header").write_text("\n".join(header))


@dataclass(frozen=True)
class Tree:
    """MeshBlocks of AthenaK: all of the mesh, those that are refined being replaced by eight.

    Attributes
    ----------
    low : tuple of floats
    spacing : float
        Of the coarsest level.
    roots : tuple of int
        Blocks of the coarsest level along each axis.
    cells : int
        Of a block along each axis.
    refined : callable
        Takes the level and the corners of a block.
    center : tuple of floats
    excised : float
        As of `Grid`.
    """

    low: tuple
    spacing: float
    roots: tuple
    cells: int
    refined: object
    center: tuple = (0.0, 0.0, 0.0)
    excised: float = 0.5
    finest: int = 3

    def leaves(self):
        """The level, the place and the corners of each block."""
        stack = [(0, place) for place in np.ndindex(*self.roots)]
        while stack:
            level, place = stack.pop()
            width = self.cells * self.spacing / 2**level
            low = np.array(self.low) + width * np.array(place)
            if level < self.finest and self.refined(level, low, low + width):
                stack += [(level + 1, tuple(2 * np.array(place) + half)) for half in np.ndindex(2, 2, 2)]
            else:
                yield level, place, low, low + width

    def points(self, level, start, shape, shift=0.5):
        """As of `Grid`."""
        return Grid(self.low, self.spacing, ()).points(level, start, shape, shift)


def write_athenak(
    path,
    geometry,
    tree,
    variables=athenak_adm,
    *,
    ghosts=0,
    version="1.1",
    extra="",
    bounds=("outflow",) * 3,
    real="f",
    time=0.0,
    cycle=0,
    only=slice(None),
):
    """A binary file."""
    edge = 2 if ghosts == 0 else 0  # the first index that is written, of blocks with two ghost zones
    blocks = []
    for level, place, low, high in list(tree.leaves())[only]:
        start = [tree.cells * p for p in place]
        box = start, (tree.cells,) * 3
        names, values = grown(geometry, tree, variables, level, box, ghosts)
        last = edge + tree.cells + 2 * ghosts - 1
        corners = [x for pair in zip(low, high, strict=True) for x in pair]
        blocks.append(struct.pack("<10i6d", *(edge, last) * 3, *place, level, *corners))
        blocks.append(values.astype(f"<{real}").tobytes())
    mesh = [f"nghost = {ghosts or 2}   # ghost cells"]
    for axis in range(3):
        n = tree.cells * tree.roots[axis]
        low, high = tree.low[axis], tree.low[axis] + n * tree.spacing
        number = axis + 1
        mesh += [f"nx{number} = {n}", f"x{number}min = {low!r}", f"x{number}max = {high!r}"]
        mesh += [f"ix{number}_bc = {bounds[axis]}"]
    sizes = [f"nx{number} = {tree.cells}" for number in (1, 2, 3)]
    parameters = "\n".join(["#--- PAR_DUMP", "<mesh>", *mesh, "<meshblock>", *sizes, extra, "<par_end>", ""])
    head = [
        f"Athena binary output version={version}",
        "  size of preheader=5",
        f"  time={time:.16e}",
        f"  cycle={cycle}",
        "  size of location=8",
        f"  size of variable={np.dtype(real).itemsize}",
        f"  number of variables={len(names)}",
        f"  variables:  {'  '.join(names)}  ",
        f"  header offset={len(parameters)}",
        parameters,
    ]
    path.write_bytes("\n".join(head).encode() + b"".join(blocks))
