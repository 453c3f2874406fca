"""Metrics on theta-phi grids from files."""

import numpy as np
import pytest

from isoembed.errors import InvalidMetric
from isoembed.io.files import FileError
from isoembed.relativity.horizons.grid_file import read_grid_data, read_metric_grid, read_metric_or_grid
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.relativity.series.shape_files import shape_files_in
from isoembed.smooth.grid_metric import GridMetric
from places import SHARED
from scattered import lattice, write_hdf5

pytest.importorskip("h5py")


def metric_arrays(spin=0.5, n=24, m=30):
    r = 1.0 + np.sqrt(1.0 - spin**2)
    theta, phi = (np.arange(n) + 0.5) * np.pi / n, 2.0 * np.pi / m * np.arange(m)
    Sigma = (r**2 + (spin * np.cos(theta)) ** 2)[:, None] + np.zeros(m)
    q_pp = (r**2 + spin**2) ** 2 * np.sin(theta)[:, None] ** 2 / Sigma
    return {"theta": theta, "phi": phi, "q_tt": Sigma, "q_pp": q_pp}


@pytest.mark.parametrize("kind", ["npz", "h5", "hdf5", "group"])
def test_metrics_on_grids(kind, tmp_path):
    arrays = metric_arrays()
    path = tmp_path / f"q.{'h5' if kind == 'group' else kind}"
    if kind == "npz":
        np.savez(path, **arrays)
    else:
        write_hdf5(path, arrays, "horizon/t0" if kind == "group" else "/")
    u = lattice(50)
    with_tp = GridMetric(**arrays, q_tp=np.zeros_like(arrays["q_tt"]))
    for metric in (read_metric_grid(path), read_horizon(path).metric, read_metric_or_grid(path).metric):
        assert isinstance(metric, GridMetric)
        np.testing.assert_array_equal(metric.tensor(u), with_tp.tensor(u))


def write_table(path, names, rows, head="{}"):
    lines = [head.format(" ".join(names)), *(" ".join(f"{value:.17g}" for value in row) for row in rows)]
    separated = [line.replace(" ", ",") for line in lines] if path.suffix == ".csv" else lines
    path.write_text("\n".join([*separated, ""]))


def nodes(arrays):
    """The names of columns, and a row for each node in a scrambled order."""
    theta, phi = np.meshgrid(arrays["theta"], arrays["phi"], indexing="ij")
    columns = {"theta": theta, "phi": phi, "q_tt": arrays["q_tt"], "q_pp": arrays["q_pp"]}
    rows = np.stack([column.ravel() for column in columns.values()], axis=1)
    return list(columns), np.random.default_rng(0).permutation(rows)


@pytest.mark.parametrize(
    ("name", "head"), [("q.csv", "{}"), ("q.txt", "# {}"), ("q.dat", "# of Kerr\n#\n# {}"), ("q.txt", "\n{}")]
)
def test_tables_with_a_row_for_each_node(name, head, tmp_path):
    arrays = metric_arrays()
    write_table(tmp_path / name, *nodes(arrays), head)
    for found in (read_metric_or_grid(tmp_path / name).metric, read_horizon(tmp_path / name).metric):
        for each in ("theta", "phi", "q_tt", "q_pp"):
            np.testing.assert_array_equal(getattr(found, each), arrays[each])
    assert shape_files_in(tmp_path) == [tmp_path / name]


@pytest.mark.parametrize("point", [".", ","])
def test_tables_of_spreadsheets_with_semicolons(point, tmp_path):
    arrays, path = metric_arrays(), tmp_path / "q.csv"
    write_table(path, *nodes(arrays))
    path.write_text(path.read_text().replace(",", ";").replace(".", point))
    for each in ("theta", "phi", "q_tt", "q_pp"):
        np.testing.assert_array_equal(getattr(read_metric_or_grid(path).metric, each), arrays[each])


def test_columns_with_numbers_and_without_phi(tmp_path):
    arrays = metric_arrays(m=1)
    columns = np.stack([arrays["theta"], arrays["q_tt"][:, 0], arrays["q_pp"][:, 0]], axis=1)
    write_table(tmp_path / "q.dat", ["1:theta", "2:q_tt", "3:q_pp"], columns, "# {}")
    np.testing.assert_array_equal(read_grid_data(tmp_path / "q.dat").metric.q_pp, arrays["q_pp"])


def test_tables_that_are_no_grid(tmp_path):
    names, rows = nodes(metric_arrays())
    write_table(tmp_path / "q.csv", names, rows[1:])
    with pytest.raises(
        FileError, match="719 rows, which are not one for each pair of its 24 angles theta and 30"
    ):
        read_metric_or_grid(tmp_path / "q.csv")
    write_table(tmp_path / "q.txt", ["th", "ph", "qtt", "qpp"], rows)
    with pytest.raises(
        FileError, match="no names theta, phi, q_tt, q_tp and q_pp above its columns, but th,"
    ):
        read_metric_or_grid(tmp_path / "q.txt")
    write_table(tmp_path / "q.csv", ["Theta", "Phi", "g_thth", "g_phph"], rows)
    with pytest.raises(
        FileError, match=r"no names theta, phi, .* above its columns, but Theta, Phi, g_thth,"
    ):
        read_metric_or_grid(tmp_path / "q.csv")
    write_table(tmp_path / "q.txt", ["theta", "q_tt", "q_pp"], rows[:, [0, 2, 3]])
    with pytest.raises(FileError, match="no column phi and 720 rows"):
        read_metric_or_grid(tmp_path / "q.txt")
    np.savez(tmp_path / "q.npz", th=rows[:, 0], qtt=rows[:, 2])
    with pytest.raises(FileError, match=r"holds th, qtt: .*on a grid, theta, phi, q_tt, q_tp and q_pp"):
        read_metric_or_grid(tmp_path / "q.npz")


def test_axisymmetric_metrics_along_theta(tmp_path):
    arrays = metric_arrays(m=1)
    flat = {name: arrays[name][:, 0] for name in ("q_tt", "q_pp")}
    np.savez(tmp_path / "q.npz", theta=arrays["theta"], phi=0.0, k=np.ones(24), **flat)
    found = read_metric_or_grid(tmp_path / "q.npz")
    np.testing.assert_array_equal(found.metric.q_tt, arrays["q_tt"])
    assert found.mean_curvature is not None


def test_q_tp_is_the_coordinate_component(tmp_path):
    theta, phi = (np.arange(16) + 0.5) * np.pi / 16, 2.0 * np.pi / 20 * np.arange(20)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    A = np.array([1.0, 0.7, 0.4])  # ds^2 = |dX|^2 of the map u -> A u
    d_t = A[:, None, None] * [np.cos(t) * np.cos(p), np.cos(t) * np.sin(p), -np.sin(t)]
    d_p = A[:, None, None] * [-np.sin(t) * np.sin(p), np.sin(t) * np.cos(p), 0.0 * t]
    q = {"q_tt": (d_t**2).sum(0), "q_tp": (d_t * d_p).sum(0), "q_pp": (d_p**2).sum(0)}
    np.savez(tmp_path / "q.npz", theta=theta, phi=phi, **q)
    u = lattice(50)
    P = np.eye(3) - u[:, :, None] * u[:, None, :]
    np.testing.assert_allclose(
        read_metric_grid(tmp_path / "q.npz").tensor(u), P @ np.diag(A**2) @ P, rtol=0, atol=1e-14
    )


def test_metrics_that_are_none(tmp_path):
    path = tmp_path / "q.npz"
    arrays = metric_arrays()
    np.savez(path, **{name: values for name, values in arrays.items() if name != "phi"})
    with pytest.raises(FileError, match=r"q.npz holds theta, q_tt, q_pp: phi missing"):
        read_metric_grid(path)
    arrays["q_pp"][3, 5] = np.nan
    np.savez(path, **arrays)
    with pytest.raises(InvalidMetric, match=r"q.npz: .*nan at node \[3, 5\]"):
        read_horizon(path)
    np.savez(path, **(arrays | {"q_pp": arrays["q_pp"][:, :4]}))
    with pytest.raises(InvalidMetric, match=r"q.npz: q_pp has the shape \(24, 4\)"):
        read_metric_grid(path)
    two = tmp_path / "q.h5"
    write_hdf5(two, metric_arrays(), "a")
    write_hdf5(two, metric_arrays(), "b")
    with pytest.raises(FileError, match="holds 2 metrics, in the groups a, b"):
        read_metric_grid(two)
    with pytest.raises(FileError, match=r"has the ending '.json', not one of .npz .h5"):
        read_metric_grid(tmp_path / "q.json")
    with pytest.raises(FileError, match="there is no file"):
        read_metric_grid(tmp_path / "none.npz")


@pytest.mark.shared
@pytest.mark.parametrize("spin", [0.5, 0.8])
def test_metrics_of_others(spin):
    metric = read_horizon(SHARED / "cases" / f"kerr_horizon_a{spin}_metric_grid.npz").metric
    r = 1.0 + np.sqrt(1.0 - spin**2)
    u = lattice(400)
    e_phi = np.stack([-u[:, 1], u[:, 0], 0.0 * u[:, 2]], axis=1) / np.hypot(u[:, 0], u[:, 1])[:, None]
    Sigma = r**2 + (spin * u[:, 2]) ** 2
    around = np.einsum("ni,nij,nj->n", e_phi, metric.tensor(u), e_phi)
    np.testing.assert_allclose(around, (r**2 + spin**2) ** 2 / Sigma, rtol=1e-14)
