"""Files of horizons, by content and ending."""

import gzip
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from horizon_texts import lopsided, shape_text
from isoembed.errors import InvalidMetric
from isoembed.gallery import KerrHorizon, triangulate
from isoembed.io.files import FileError
from isoembed.io.vtk import write as write_vtk
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape, triangulate_star_shaped
from isoembed.relativity.horizons.horizon_file import read_horizon
from isoembed.surface.measures import volume
from places import SHARED
from scattered import bumpy, is_closed_and_outward, lattice, write_hdf5

h5py = pytest.importorskip("h5py")


@pytest.mark.parametrize("kind", ["npz", "h5"])
def test_surfaces_as_arrays(kind, tmp_path):
    points = bumpy(lattice(120)) + np.array([0.0, 3.0, 0.0])
    x, y, z = points.T.reshape(3, 10, 12)
    path = tmp_path / f"s.{kind}"
    arrays = {"x": x, "y": y, "z": z, "center": [0.0, 3.0, 0.0], "time": 2.5, "expansion": x - y}
    if kind == "npz":
        np.savez(path, **arrays)
    else:
        write_hdf5(path, arrays, "ah1")
    shape = read_horizon(path)
    assert isinstance(shape, CoordinateShape)
    np.testing.assert_array_equal(shape.points, points)
    assert is_closed_and_outward(shape.points, shape.faces, shape.center)
    assert shape.time == 2.5 and list(shape.fields) == ["expansion"]
    np.testing.assert_array_equal(shape.fields["expansion"], points[:, 0] - points[:, 1])
    assert f"{path} holds the coordinates of 120 points of a horizon and expansion there" in shape.contents


def test_triangles_of_a_file_are_kept(tmp_path):
    """Also where the surface is not star-shaped: a sphere that is bent into a banana."""
    u, faces = lattice(300), None
    _, faces = triangulate_star_shaped(u, np.zeros(3), "x")
    angle, r = 2.2 * u[:, 0], 2.0 + 0.4 * u[:, 1]
    points = np.stack([r * np.sin(angle), r * np.cos(angle), 0.4 * u[:, 2]], axis=1)
    if volume(faces, points) > 0:
        faces = faces[:, ::-1]
    np.savez(tmp_path / "banana.npz", points=points, faces=faces)
    shape = read_horizon(tmp_path / "banana.npz")
    np.testing.assert_array_equal(shape.points, points)
    np.testing.assert_array_equal(shape.faces, faces[:, ::-1])
    assert volume(shape.faces, shape.points) > 0


def bad_arrays():
    points = bumpy(lattice(30))
    _, faces = triangulate_star_shaped(points, np.zeros(3), "x")
    hole = np.where(np.arange(30)[:, None] == 3, np.nan, points)
    return {
        "nothing of use": ({"a": points}, FileError, "holds a: neither a metric .* nor points"),
        "shape": ({"points": points.T}, FileError, r"points has the shape \(3, 30\), not \(V, 3\)"),
        "x, y, z": (
            {"x": points[:, 0], "y": points[1:, 1], "z": points[:, 2]},
            FileError,
            r"x, y and z have the shapes \(30,\), \(29,\) and \(30,\)",
        ),
        "words": ({"points": points.astype(str)}, FileError, "the points are not numbers"),
        "not finite": ({"points": hole}, FileError, "point 3 is not finite"),
        "center": ({"points": points, "center": [1.0]}, FileError, r"the center has the shape \(1,\)"),
        "open": ({"points": points, "faces": faces[1:]}, InvalidMetric, "s.npz: edge .* not closed"),
        "more points": (
            {"points": np.vstack([points, points[:1]]), "faces": faces},
            InvalidMetric,
            "there are 31 points, but 30 in faces",
        ),
        "empty": ({"points": np.empty((0, 3))}, FileError, "s.npz: 0 points: that is not a surface"),
        "empty, triangles": (
            {"points": np.empty((0, 3)), "faces": faces},
            FileError,
            "s.npz: 0 points: that is not a surface",
        ),
        "plane": (
            {"points": points * [1.0, 1.0, 0.0]},
            FileError,
            "s.npz: the 30 points lie in a plane",
        ),
        "plane, center": (
            {"points": points * [1.0, 1.0, 0.0], "center": [0.0, 0.0, 1.0]},
            FileError,
            "s.npz: the 30 points lie in a plane",
        ),
        "line": (
            {"points": points[:, :1] * [1.0, 2.0, 3.0]},
            FileError,
            "s.npz: the 30 points lie on a line",
        ),
        "one point": (
            {"points": np.full((100, 3), 0.1)},
            FileError,
            "s.npz: the 100 points are one point",
        ),
        "center outside": (
            {"points": points, "center": [5.0, 0.0, 0.0]},
            FileError,
            "s.npz: .* not complete",
        ),
    }


@pytest.mark.parametrize("arrays, error, message", bad_arrays().values(), ids=bad_arrays())
def test_arrays_that_are_no_surface(arrays, error, message, tmp_path):
    np.savez(tmp_path / "s.npz", **arrays)
    with pytest.raises(error, match=message):
        read_horizon(tmp_path / "s.npz")


def test_several_surfaces_in_one_file(tmp_path):
    path = tmp_path / "s.h5"
    for group in ("ah1", "ah2"):
        write_hdf5(path, {"points": lattice(20)}, group)
    with pytest.raises(FileError, match="holds 2 surfaces, in the groups ah1, ah2"):
        read_horizon(path)


def test_spectre_is_recognized(tmp_path):
    path = tmp_path / "horizons.h5"
    for time in (0, 1):
        points = lattice(40)
        arrays = {f"InertialCoordinates_{axis}": points[:, i] for i, axis in enumerate("xyz")}
        write_hdf5(path, arrays, f"AhA.vol/ObservationId{time}")
    with h5py.File(path, "a") as file:
        file["AhA.vol/ObservationId0"].attrs["observation_value"] = 0.25
    assert read_horizon(path).time == 0.25
    with h5py.File(path, "a") as file:
        file["AhA.vol/ObservationId1"].attrs["observation_value"] = 0.5
    with pytest.raises(FileError, match=r"choose one of t = 0.25, 0.5"):
        read_horizon(path)


# Text files.


def polydata(points, polygons, fields):
    """As QuasiLocalMeasures writes it."""
    n = len(points)
    text = ["# vtk DataFile Version 2.0", "Horizon data", "ASCII", "DATASET POLYDATA", f"POINTS  {n} float"]
    text += [" ".join(f"{x:.15E}" for x in point) for point in points]
    text += ["", f"POLYGONS  {len(polygons)}  {sum(len(p) + 1 for p in polygons)}"]
    text += [" ".join(map(str, [len(p), *p])) for p in polygons]
    text += ["", f"POINT_DATA  {n}", ""]
    for name, values in fields.items():
        text += [f"SCALARS {name} float 1", "LOOKUP_TABLE default", *map(str, values), ""]
    return "\n".join(text)


def rings(n=12, m=18):
    """Quadrilaterals between circles of latitude, open at the poles."""
    t, p = np.meshgrid((np.arange(n) + 0.5) * np.pi / n, 2.0 * np.pi / m * np.arange(m), indexing="ij")
    u = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=2).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n - 1), np.arange(m), indexing="ij"))
    here, there = m * i + j, m * i + (j + 1) % m
    return bumpy(u) + np.array([4.0, 0.0, 0.0]), np.column_stack([here, here + m, there + m, there])


@pytest.mark.parametrize("zipped", [False, True])
def test_polygons_of_quasi_local_measures(zipped, tmp_path):
    points, quads = rings()
    text = polydata(points, quads, {"shape": points[:, 0], "repsi2": points[:, 1]})
    text += f"\nVECTORS v double\n{' '.join(map(str, points.ravel()))}\nCELL_DATA {len(quads)}\n"
    text += f"FIELD f 1\narea 1 {len(quads)} float\n{' '.join('1' for _ in quads)}\n"
    path = tmp_path / ("surface.vtk.gz" if zipped else "surface.vtk")
    path.write_bytes(gzip.compress(text.encode()) if zipped else text.encode())
    shape = read_horizon(path)
    np.testing.assert_allclose(shape.points, points, rtol=1e-14)
    assert is_closed_and_outward(shape.points, shape.faces, shape.center)
    assert list(shape.fields) == ["shape", "repsi2", "v"]
    np.testing.assert_allclose(shape.fields["repsi2"], points[:, 1], rtol=1e-14)
    np.testing.assert_allclose(shape.fields["v"], points, rtol=1e-14)


def bad_polydata():
    points, quads = rings(6, 8)
    text = polydata(points, quads, {"shape": points[:, 0]})
    folded = points.copy()
    folded[20] = 2.0 * np.array([4.0, 0.0, 0.0]) - points[20]
    return {
        "binary": (text.replace("ASCII", "BINARY"), "is not known in a VTK file"),
        "neither": (text.replace("ASCII", "UTF-8"), "neither ASCII nor BINARY"),
        "cut in the points": (text[:800], r"ends after \d+ of 144 numbers of the points"),
        "cut in a name": (text[: text.index("SCALARS") + 7], "ends early"),
        "a word": (text.replace("E+00", "E+00x", 1), "among the points, could not convert"),
        "count": (text.replace("POINTS  48", "POINTS  many"), "'many' is not a number of points"),
        "corner": (
            text.replace("\n4 0 8", "\n4 0 99", 1),
            "number 0 of the POLYGONS is not made of the 48 points",
        ),
        "not finite": (text.replace("E+00", "E+999", 1), "point 0 is not finite"),
        "key": (text.replace("POINT_DATA", "POINT_DATUM"), "'POINT_DATUM' is not known"),
        "no polygons": (polydata(points, [], {}), "has no polygons"),
        "empty": (polydata(points[:0], quads, {}), "is not made of the 0 points"),
        "plane": (polydata(points * [1, 0, 1], quads, {}), "surface.vtk: the 48 points lie in a plane"),
        "folded": (polydata(folded, quads, {}), r"(folds over|one direction)"),
    }


@pytest.mark.parametrize("text, message", bad_polydata().values(), ids=bad_polydata())
def test_malformed_polygons(text, message, tmp_path):
    path = tmp_path / "surface.vtk"
    path.write_text(text)
    with pytest.raises(FileError, match=message):
        read_horizon(path)


def test_meshes(tmp_path):
    vertices, faces = triangulate(KerrHorizon(), 60)[:2]
    write_vtk(tmp_path / "m.vtk", {"vertices": vertices, "faces": faces})
    obj = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
    obj += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces.tolist())
    (tmp_path / "m.obj.gz").write_bytes(gzip.compress(obj.encode()))
    for name in ("m.vtk", "m.obj.gz"):
        shape = read_horizon(tmp_path / name)
        np.testing.assert_array_equal(shape.points, vertices)
        np.testing.assert_array_equal(np.sort(shape.faces), np.sort(faces))


def test_ahfinderdirect_is_recognized_by_its_first_lines(tmp_path):
    for name in ("h.t8.ah1.gp", "shape.txt", "h.t8.ah1.gp.gz"):
        text = shape_text(lopsided, 5).encode()
        (tmp_path / name).write_bytes(gzip.compress(text) if name.endswith("gz") else text)
        assert len(read_horizon(tmp_path / name).points) == 98


def test_other_files(tmp_path):
    path = tmp_path / "BH_diagnostics.ah1.gp"
    path.write_text("# column  1 = cctk_iteration\n0\t0.0\n")
    with pytest.raises(FileError, match=r"has no line '# N_patches = ...'"):
        read_horizon(path)
    path = tmp_path / "notes.txt"
    path.write_text("nothing")
    with pytest.raises(
        FileError,
        match=r"is neither a file of AHFinderDirect .* SpECTRE .*, nor a table .* one of the endings",
    ):
        read_horizon(path)
    with pytest.raises(FileError, match="there is no file"):
        read_horizon(tmp_path / "none.npz")


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("no_such_module:FORMAT", "cannot be loaded from no_such_module:FORMAT: ModuleNotFoundError: "),
        ("math:pi", "is math:pi, which is not a HorizonFormat"),
    ],
)
def test_broken_formats_of_others(value, sentence, tmp_path, monkeypatch):
    points = [EntryPoint("theirs", value, "isoembed.horizon_formats")]
    monkeypatch.setattr("isoembed.relativity.horizons.horizon_file.entry_points", lambda group: points)
    (tmp_path / "a.theirs").write_text("nothing that anybody knows")
    with pytest.raises(FileError, match=f"the format 'theirs' {sentence}"):
        read_horizon(tmp_path / "a.theirs")


@pytest.mark.shared
def test_the_surface_of_others():
    shape = read_horizon(SHARED / "real" / "kuibit" / "surface01_00000000.vtk.gz")
    assert len(shape.points) == 37 * 76 and len(shape.faces) == 2 * 37 * 76 - 4
    assert is_closed_and_outward(shape.points, shape.faces, shape.center)
    assert {"shape", "repsi2", "renprho", "renpmu"} <= set(shape.fields)
    np.testing.assert_allclose(np.linalg.norm(shape.points - shape.center, axis=1), 0.2528, rtol=1e-3)


class TestOfHDF5FilesWithoutASurface:
    def refusal(self, path):
        with pytest.raises(FileError) as refused:
            read_horizon(path)
        return str(refused.value)

    def test_the_data_sets_of_all_groups_are_named(self, tmp_path):
        path = tmp_path / "a.h5"
        for group in ("deep/er", "b"):
            write_hdf5(path, {"mass": np.ones(3)}, group)
        assert "holds the data sets b/mass, deep/er/mass: neither a metric" in self.refusal(path)

    def test_of_many_the_first_are_named(self, tmp_path):
        path = tmp_path / "a.h5"
        write_hdf5(path, {f"x{k:02d}": np.ones(3) for k in range(12)}, "g")
        assert "g/x07 and 4 more: neither" in self.refusal(path)

    def test_groups_are_named_where_there_is_nothing_else(self, tmp_path):
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file.create_group("one/two")
        assert "holds no data sets, but the groups one, one/two: neither" in self.refusal(tmp_path / "a.h5")
        with h5py.File(tmp_path / "b.h5", "w"):
            pass
        assert "holds nothing: neither" in self.refusal(tmp_path / "b.h5")

    @pytest.mark.parametrize(
        "group, name, kind",
        [
            ("AhA.dir", "ArealMass.dat", "it looks like SpEC's Horizons.h5, which has the masses"),
            ("", "ADMBASE::gxx it=0 tl=0 rl=0 c=0", "it looks like output of Carpet"),
            (
                "Norms.dat",
                "x",
                "it has no tables *_Ylm.dat with coefficients of surfaces",
            ),
        ],
    )
    def test_known_kinds_are_named(self, group, name, kind, tmp_path):
        path = tmp_path / "Horizons.h5"
        write_hdf5(path, {name: np.ones((4, 2))}, group or "/")
        assert kind in self.refusal(path)
