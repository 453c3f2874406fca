"""Slices in files of GRChombo, GRTeclyn, CarpetX and AthenaK, written by the layouts of their sources."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

h5py = pytest.importorskip("h5py")

import patch_data  # noqa: E402
from isoembed.errors import InvalidParameter  # noqa: E402
from isoembed.io.files import FileError  # noqa: E402
from isoembed.relativity.horizons.finder import find_horizon  # noqa: E402
from isoembed.relativity.series.moments import moments  # noqa: E402
from isoembed.relativity.series.slice_files import (  # noqa: E402
    read_slice,
    slices_in_file,
    slices_in_folder,
    slices_of_pattern,
)
from isoembed.relativity.spacetimes.kerr_slices import KerrSchild  # noqa: E402
from isoembed.relativity.spacetimes.star_surface import StarSurface  # noqa: E402
from patch_data import Grid, Tree, grchombo, plain, write_amrex, write_athenak, write_chombo, z4c  # noqa: E402

KERR = KerrSchild(1.0, (0.1, 0.2, 0.2))
UPRIGHT = KerrSchild(1.0, (0.0, 0.0, 0.3))
STATIC = KerrSchild(1.0, (0.0, 0.0, 0.0))
LOW = (-6.0,) * 3
HALVES = (((0, 0, 0), (24, 24, 10)), ((0, 0, 10), (24, 24, 14)))
BOXES = (HALVES, (((12, 12, 12), (24, 24, 24)),))
AT_ORIGIN = Grid(LOW, 0.5, BOXES)
AROUND = Grid(
    (0.0,) * 3, 0.5, ((((-12,) * 3, (24,) * 3),), (((-12,) * 3, (24,) * 3),))
)  # with negative indices
IN_CORNER = Grid((0.0,) * 3, 0.5, BOXES, (6.0,) * 3)  # as GRChombo has it


TREE = Tree(
    (-8.0,) * 3, 0.5, (4,) * 3, 8, lambda level, low, high: level < 1 and np.abs(low + high).max() < 5
)
LAYOUTS = {
    "GRChombo": (
        lambda path, **k: write_chombo(path.with_suffix(".hdf5"), KERR, IN_CORNER, **k),
        ".hdf5",
        6.0,
    ),
    "GRTeclyn": (lambda path, **k: write_amrex(path, KERR, AT_ORIGIN, **k), "", 0.0),
    "AthenaK": (lambda path, **k: write_athenak(path.with_suffix(".bin"), KERR, TREE, **k), ".bin", 0.0),
}


def sphere(radius, n=200):
    u = np.random.default_rng(1).normal(size=(n, 3))
    return radius * u / np.linalg.norm(u, axis=1)[:, None]


def worst(geometry, x, center=0.0, exact=KERR):
    """Largest errors of the metric, of its gradient and of the extrinsic curvature."""
    return [
        np.abs(getattr(geometry, name)(x + center) - getattr(exact, name)(x)).max()
        for name in ("metric", "gradient", "extrinsic_curvature")
    ]


def without(*names, of=grchombo):
    """Variables of which some are missing."""

    def variables(*arguments):
        return {name: values for name, values in of(*arguments).items() if name not in names}

    return variables


def nothing(geometry, grid, points):
    """Variables that make no slice."""
    return {"Weyl4_Re": points[..., 0]}


@pytest.fixture(scope="module", params=LAYOUTS)
def kerr(request, tmp_path_factory):
    """A slice of each layout: its path, and where the hole is."""
    write, ending, center = LAYOUTS[request.param]
    path = tmp_path_factory.mktemp("kerr") / "run000064"
    write(path, time=1.5)
    return path.with_suffix(ending), center


def test_two_levels(kerr):
    path, center = kerr
    geometry = read_slice(path)
    assert (np.array(worst(geometry, sphere(1.9), center)) < [3e-5, 5e-4, 1e-4]).all()
    coarse = worst(geometry, sphere(3.6), center)
    assert (np.array(coarse) < [3e-4, 2e-3, 2e-3]).all()
    assert coarse[0] > 1e-6


@pytest.fixture(scope="module")
def area():
    return find_horizon(KERR).area


@pytest.mark.slow
def test_the_horizon_is_found(kerr, area):
    path, center = kerr
    found = find_horizon(read_slice(path), StarSurface.sphere((center,) * 3, 2.2))
    assert abs(found.area / area - 1) < 1e-4
    np.testing.assert_allclose(found.surface.center, center, atol=1e-3)


@pytest.mark.parametrize("code", LAYOUTS)
def test_ghost_zones_make_no_difference(tmp_path, code):
    write, ending, center = LAYOUTS[code]

    def values(ghosts):
        path = tmp_path / f"ghosts{ghosts}"
        write(path, ghosts=ghosts)
        return read_slice(path.with_suffix(ending)).metric(sphere(1.9, 50) + center)

    two = values(2)
    for ghosts in (0, 4):
        np.testing.assert_array_equal(values(ghosts), two)


@pytest.mark.parametrize(
    "write",
    [
        lambda path: write_chombo(path / "a.hdf5", KERR, AROUND, plain),
        lambda path: write_amrex(path / "plt", KERR, AT_ORIGIN, plain),
        lambda path: write_amrex(path / "plt", KERR, AT_ORIGIN, grchombo, nodal=True),
        lambda path: write_amrex(path / "plt", KERR, AT_ORIGIN, grchombo, real=">f8"),
        lambda path: write_amrex(path / "plt", KERR, AT_ORIGIN, grchombo, real="<f4"),
        lambda path: write_athenak(path / "a.bin", KERR, TREE, z4c(-4.0)),
        lambda path: write_athenak(
            path / "a.bin", KERR, TREE, z4c(-2.0), extra="<z4c>\nchi_psi_power = -2 # psi^-2"
        ),
        lambda path: write_athenak(path / "a.bin", KERR, TREE, real="d"),
    ],
)
def test_variables_and_numbers(tmp_path, write):
    write(tmp_path)
    [listed] = slices_in_folder(tmp_path)
    assert (np.array(worst(listed.source.whole(), sphere(1.9))) < [5e-5, 5e-4, 1e-4]).all()


def test_metrics_of_which_chi_vanishes_are_missing_there(tmp_path):
    def punctured(geometry, grid, points):
        out = grchombo(geometry, grid, points)
        return out | {"chi": np.where(np.linalg.norm(points, axis=-1) < 0.5, 0.0, out["chi"])}

    write_amrex(tmp_path / "plt", KERR, AT_ORIGIN, punctured)
    geometry = read_slice(tmp_path / "plt")
    x = sphere(1.9)
    x = x[np.abs(x).max(axis=1) > 1.7]  # farther than four cells from where chi vanishes
    assert len(x) > 10
    assert (np.array(worst(geometry, x)) < [5e-5, 5e-4, 1e-4]).all()
    assert np.isnan(geometry.metric(np.zeros((1, 3)))).all()


def test_coarse_values_of_athenak_are_made_of_finer_ones(tmp_path):
    """Three levels in blocks of eight cells: the coarsest lies beside blocks that are two levels finer."""

    def refined(level, low, high):
        return np.abs(low + high).max() < 12.0 / 2**level and level < 2

    path = tmp_path / "a.bin"
    write_athenak(path, KERR, replace(TREE, spacing=1.0, low=(-16.0,) * 3, refined=refined), real="d")
    geometry = read_slice(path)
    assert [level.spacing[0] for level in geometry._levels] == [1.0, 0.5, 0.25]
    x = sphere(1.0) * np.linspace(2.0, 11.0, 200)[:, None]
    errors = np.abs(geometry.metric(x) - KERR.metric(x)).max(axis=(1, 2))
    assert errors.max() < 3e-2
    assert errors[np.linalg.norm(x, axis=1) > 5.0].max() < 1e-3


def test_reflections_of_athenak(tmp_path):
    half = replace(TREE, low=(-8.0, -8.0, 0.0), roots=(4, 4, 2))
    path = tmp_path / "a.bin"
    write_athenak(path, UPRIGHT, half, bounds=("outflow", "outflow", "reflect"))
    assert (np.array(worst(read_slice(path), sphere(1.9), exact=UPRIGHT)) < [3e-5, 5e-4, 1e-4]).all()
    write_athenak(path, UPRIGHT, half)
    with pytest.raises(InvalidParameter, match="is in no refinement level"):
        read_slice(path).metric(sphere(1.9))


@pytest.mark.parametrize(("geometry", "axes"), [(UPRIGHT, (2,)), (STATIC, (0, 1, 2))])
def test_mirrors_of_grchombo(tmp_path, geometry, axes):
    """Half and an eighth of a domain: the ghost zones at a mirror are copies, those elsewhere are not."""
    start, shape = np.where(np.isin(range(3), axes), 0, -12), np.where(np.isin(range(3), axes), 12, 24)
    grid = Grid((0.0,) * 3, 0.5, (((start, shape),), ((start, shape),)), excised=0.6)
    path, x = tmp_path / "a.hdf5", sphere(1.9)
    write_chombo(path, geometry, grid, mirrors=axes)
    assert (np.array(worst(read_slice(path), x, exact=geometry)) < [5e-5, 1e-3, 3e-4]).all()
    for others in ({"mirrors": axes[1:]}, {"mirrors": axes, "ghosts": 1}):
        write_chombo(path, geometry, grid, **others)
        with pytest.raises(InvalidParameter, match="is in no refinement level"):
            read_slice(path).metric(x)


def test_files_of_the_processes_of_athenak(tmp_path, kerr):
    x = sphere(1.9, 50)
    for rank, only in enumerate((slice(0, 20), slice(20, 70), slice(70, None))):
        folder = tmp_path / f"rank_{rank:08d}"
        folder.mkdir()
        write_athenak(folder / "a.bin", KERR, TREE, cycle=8, time=0.5, only=only)
    [listed] = slices_in_file(tmp_path / "rank_00000001" / "a.bin")
    assert (listed.iteration, listed.time) == (8, 0.5)
    assert listed.source.name.endswith("rank_00000000/a.bin and 2 more")
    assert worst(listed.source.whole(), x)[0] < 3e-5
    shutil.rmtree(tmp_path / "rank_00000002")
    [listed] = slices_in_file(tmp_path / "rank_00000001" / "a.bin")
    with pytest.raises(FileError, match=r"has MeshBlocks for 0\.\d+ of the mesh only"):
        listed.source.whole()


def test_plot_files_of_groups_of_variables(tmp_path):
    def some(wanted):
        def variables(*arguments):
            return {name: values for name, values in plain(*arguments).items() if name[0] == wanted}

        return variables

    for iteration in (0, 8):
        for group, wanted in (("metric", "g"), ("curv", "k")):
            path = tmp_path / f"admbasex-{group}.it{iteration:08d}"
            write_amrex(
                path, KERR, AT_ORIGIN, some(wanted), nodal=True, iteration=iteration, time=0.1 * iteration
            )
    listed = slices_in_folder(tmp_path)
    assert [(each.iteration, each.time) for each in listed] == [(0, 0.0), (8, 0.8)]
    assert worst(listed[1].source.whole(), sphere(1.9))[0] < 3e-5
    with pytest.raises(FileError, match=r"has no kxx, kxy, kxz, kyy, kyz, kzz: gxx, .* are needed"):
        read_slice(tmp_path / "admbasex-metric.it00000008")


def test_other_output_of_a_run_is_passed_over(tmp_path):
    """Constraints, plots of a few variables, and ``adm`` beside ``z4c``; two runs in one folder are not."""
    bins, plots, levels = (tmp_path / name for name in ("bin", "plots", "levels"))
    for folder in (bins, plots, levels):
        folder.mkdir()
    for name, variables in (("con", nothing), ("z4c", z4c(-4.0)), ("adm", patch_data.athenak_adm)):
        write_athenak(bins / f"run.{name}.00000.bin", KERR, TREE, variables)
    write_athenak(bins / "run.con.00001.bin", KERR, TREE, nothing, cycle=7, time=0.1)
    write_amrex(plots / "admbasex-metric", KERR, AT_ORIGIN, plain, nodal=True)
    write_amrex(plots / "hydrobasex-rho", KERR, AT_ORIGIN, nothing)
    write_chombo(levels / "chk_000000.hdf5", KERR, IN_CORNER)
    write_chombo(levels / "p_000000.hdf5", KERR, IN_CORNER, without("A33"))
    names = [
        [each.source.name.rpartition("/")[2] for each in slices_in_folder(f)] for f in (bins, plots, levels)
    ]
    assert names == [["run.adm.00000.bin", "run.con.00001.bin"], ["admbasex-metric"], ["chk_000000.hdf5"]]
    write_athenak(bins / "second.adm.00000.bin", KERR, TREE)
    assert len(slices_in_folder(bins)) == 3


def test_moments_of_a_run(tmp_path):
    run = tmp_path / "run"
    run.mkdir()
    for iteration in (0, 16):
        write_chombo(
            run / f"p_{iteration:06d}.3d.hdf5", KERR, IN_CORNER, iteration=iteration, time=0.25 * iteration
        )
    (run / "pout.0").write_text("a log")
    (run / "p_000032.3d.hdf5").write_bytes((run / "p_000016.3d.hdf5").read_bytes()[:5000])
    listed = slices_in_folder(run)
    assert [(each.iteration, each.time) for each in listed] == [(0, 0.0), (16, 4.0), (32, None)]
    with pytest.raises(FileError, match=r"p_000032\.3d\.hdf5 is not a readable HDF5 file"):
        listed[2].source.read(np.zeros(3), np.ones(3))
    before = listed[1].source.digest()
    assert before == listed[1].source.digest() != listed[0].source.digest()
    by_name = slices_of_pattern(str(run / "p_{iteration:06d}.3d.hdf5"))
    assert [(each.iteration, each.time) for each in by_name] == [(0, 0.0), (16, 4.0), (32, None)]
    np.savez(tmp_path / "ah1.16.npz", points=6.0 + sphere(2.0))
    [moment] = moments([tmp_path / "ah1.16.npz"], run)
    assert moment.slice.name == str(run / "p_000016.3d.hdf5")
    with pytest.raises(FileError, match=r"run holds 3 slices, and isoembed.relativity.read_slice reads one"):
        read_slice(run)


@pytest.mark.parametrize("code", ["GRChombo", "GRTeclyn"])
@pytest.mark.parametrize(
    ("variables", "sentence"),
    [
        (without("A33", "K"), "has no A33, K: chi, h11, .*, K are needed"),
        (without("chi"), "has no chi: chi, h11, .* are needed"),
        (without("kxz", of=plain), "has no kxz: gxx, gxy, gxz, .* kzz are needed"),
        (nothing, "has none of the variables that make a slice: chi, h11, .*; or gxx, gxy, "),
    ],
)
def test_missing_variables_are_named(tmp_path, code, variables, sentence):
    write, ending, _ = LAYOUTS[code]
    write(tmp_path / "a", variables=variables)
    with pytest.raises(FileError, match=rf"a{ending} {sentence}"):
        read_slice((tmp_path / "a").with_suffix(ending))


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"variables": without("adm_Kyz", of=patch_data.athenak_adm)},
            "has no adm_Kyz: adm_gxx, .* are needed",
        ),
        ({"variables": without("z4c_Theta", of=z4c(-4.0))}, "has no z4c_Theta: z4c_chi, .* are needed"),
        ({"variables": nothing}, "has none of the variables that make a slice: adm_gxx, .*; or z4c_chi"),
        ({"version": "1.2"}, r"has the version '1\.2' of AthenaK, not 1\.1"),
        ({"only": slice(1, None)}, r"has MeshBlocks for 0\.\d+ of the mesh only"),
    ],
)
def test_files_of_athenak_that_lack_something(tmp_path, given, sentence):
    write_athenak(tmp_path / "a.bin", KERR, TREE, **given)
    with pytest.raises(FileError, match=rf"a\.bin {sentence}"):
        read_slice(tmp_path / "a.bin")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (b"nx3 = 32", b"nx3 =  1", "is not three-dimensional: there is one cell along x3"),
        (b"size of preheader=5", b"size of preheader=x", "is cut short or damaged"),
        (b"variables=12", b"variables=13", "has the names of 12 variables, not of 13"),
        (
            b"size of preheader=5",
            b"size of preheader=6\n  coarsening factor=2",
            "averages over several cells",
        ),
        (
            b"\x02\0\0\0\x09\0\0\0" * 3,
            b"\x02\0\0\0\x09\0\0\0" * 2 + b"\x04\0\0\0" * 2,
            "is a plane or a line",
        ),
    ],
)
def test_damaged_files_of_athenak(tmp_path, old, new, sentence):
    path = tmp_path / "a.bin"
    write_athenak(path, KERR, TREE)
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))
    with pytest.raises(FileError, match=sentence):
        read_slice(path)


@pytest.mark.parametrize(
    ("length", "sentence"),
    [(-100, "is cut short in the MeshBlock 119"), (1000, "has no MeshBlock|cut short")],
)
def test_files_of_athenak_that_are_cut_short(tmp_path, length, sentence):
    path = tmp_path / "a.bin"
    write_athenak(path, KERR, TREE)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(FileError, match=sentence):
        read_slice(path)


def change(file, old, new):
    text = file.read_bytes()
    assert old in text
    file.write_bytes(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (
            lambda p: change(p / "Header", b"V1.1", b"V1.2"),
            "Header has the version 'HyperCLaw-V1.2', not HyperCLaw-V1.1",
        ),
        (lambda p: change(p / "Header", b"\n3\n", b"\n2\n"), "plt has 2 dimensions of space, not three"),
        (
            lambda p: change(p / "Header", b"\n0\n0\n0 2 ", b"\n1\n0\n0 2 "),
            "is not in Cartesian coordinates \\(0\\), but in those of the kind 1",
        ),
        (
            lambda p: (p / "Header").write_bytes((p / "Header").read_bytes()[:300]),
            "Header is cut short or damaged",
        ),
        (
            lambda p: change(p / "Level_0/Cell_H", b"1\n1\n", b"2\n1\n"),
            "Cell_H has the version 2, not 1",
        ),
        (
            lambda p: change(p / "Level_0/Cell_H", b"Cell_D_00000 0", b"Cell_D_00000 x"),
            "Cell_H is cut short or damaged",
        ),
        (
            lambda p: change(p / "Level_0/Cell_H", b"\n16\n", b"\n15\n"),
            "Cell_H has 15 variables, but Header names 16",
        ),
        (lambda p: (p / "Level_0/Cell_H").unlink(), "cannot read .*Cell_H: No such file"),
        (lambda p: (p / "Level_1/Cell_D_00000").unlink(), "cannot read .*Cell_D_00000: No such file"),
        (
            lambda p: (p / "Level_1/Cell_D_00000").write_bytes(b"FAB"),
            "has no box of numbers in a known format at byte 0",
        ),
        (
            lambda p: change(p / "Level_1/Cell_D_00000", b"(35,35,35)", b"(34,35,35)"),
            "differs from that in Cell_H",
        ),
        (
            lambda p: (p / "Level_1/Cell_D_00000").write_bytes(
                (p / "Level_1/Cell_D_00000").read_bytes()[:200_000]
            ),
            "Cell_D_00000 is cut short",
        ),
    ],
)
def test_damaged_plot_files(tmp_path, spoil, sentence):
    write_amrex(tmp_path / "plt", KERR, AT_ORIGIN)
    spoil(tmp_path / "plt")
    with pytest.raises(FileError, match=sentence):
        read_slice(tmp_path / "plt").metric(sphere(1.9))


def spoiled(file, name, value):
    group = file["level_1"]
    del group[name]
    group[name] = value


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (
            lambda file: file["Chombo_global"].attrs.modify("SpaceDim", 2),
            "has 2 dimensions of space, not three",
        ),
        (
            lambda file: spoiled(file, "data:offsets=0", np.array([0, 5])),
            "the data of level 1 do not fit its 1 boxes",
        ),
        (
            lambda file: spoiled(file, "data:datatype=0", np.zeros(7)),
            "the data of level 1 do not fit its 1 boxes",
        ),
        (lambda file: file.pop("level_1"), "is not a readable HDF5 file: .*level_1"),
        (lambda file: file.attrs.pop("num_components"), "is not a readable HDF5 file: .*num_components"),
    ],
)
def test_damaged_files_of_chombo(tmp_path, spoil, sentence):
    path = tmp_path / "a.hdf5"
    write_chombo(path, KERR, IN_CORNER)
    with h5py.File(path, "a") as file:
        spoil(file)
    with pytest.raises(FileError, match=sentence):
        read_slice(path).metric(6.0 + sphere(1.9))


def test_what_is_no_slice(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["psi"] = np.zeros(3)
    with pytest.raises(
        FileError, match=r"a\.h5 has no gxx, nor SpatialMetric_xx .* nor MeshBlocks as AthenaK"
    ):
        read_slice(tmp_path / "a.h5")
    (tmp_path / "a.bin").write_bytes(b"something else")
    with pytest.raises(FileError, match=r"a\.bin has no gxx, nor .* MeshBlocks as AthenaK writes them"):
        read_slice(tmp_path / "a.bin")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match=r"there are no files of slices in .*empty: there are no files in"):
        read_slice(tmp_path / "empty")
    with pytest.raises(FileError, match=r"a\.txt has the ending '\.txt', not one of"):
        read_slice(tmp_path / "a.txt")
