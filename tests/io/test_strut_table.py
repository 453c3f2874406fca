"""Strut tables as metrics: lengths by type or by strut, digits, and what is wrong with them."""

import re
from contextlib import nullcontext

import numpy as np
import pytest

import isoembed
import zoo
from domes import dome
from isoembed import InvalidMetric, InvalidParameter, MeshNote, embed
from isoembed.io import FileError, read_metric
from isoembed.io.surface import surface_of
from isoembed.mesh.triangulation import Triangulation
from isoembed.struts import strut_table
from isoembed.surface.alignment import aligned

OCTAHEDRON = [(0, 1), (0, 2), (0, 3), (0, 4), (5, 1), (5, 2), (5, 3), (5, 4), (1, 2), (2, 3), (3, 4), (4, 1)]


def edges_of(faces):
    return isoembed.Triangulation(faces).edges.tolist()


def written(tmp_path, text):
    path = tmp_path / "struts.csv"
    path.write_text(text, encoding="utf-8")
    return path


def rows(edges, *more):
    return "".join(",".join(map(str, (*ends, *more))) + "\n" for ends in edges)


def typed(table, decimals):
    """As a builder types it: lengths by type, and the type of each strut."""
    legend = "".join(f"{one.name},{one.length:.{decimals}f}\n" for one in table.struts)
    struts = "".join(
        f"{a},{b},{table.struts[k].name}\n" for (a, b), k in zip(table.edges, table.types, strict=True)
    )
    return f"type,length\n{legend}\nfrom,to,type\n{struts}"


def surface(vertices, faces):
    return surface_of({"vertices": vertices, "faces": faces}, "test")


def farthest(found, true):
    """The farthest vertex, of the surface or of its mirror image."""
    images = (found.vertices, found.vertices * [1, 1, -1])
    return min(np.linalg.norm(aligned(image, true) - true, axis=1).max() for image in images)


@pytest.mark.parametrize(
    ("missing", "sentence"),
    [
        ({("A0", "A2")}, "perhaps the strut between A0 and A2, or A4 and A5, is missing in the table"),
        ({("A0", "A2"), ("A0", "A4")}, "perhaps 2 struts across it are missing in the table"),
    ],
)
def test_missing_struts_are_named_by_the_hubs_around_the_hole(missing, sentence, tmp_path):
    edges = {(f"A{a}", f"A{b}") for a, b in Triangulation(zoo.icosahedron()[1]).edges.tolist()}
    path = tmp_path / "dome.csv"
    path.write_text("\n".join(["from,to,length", *(f"{a},{b},1" for a, b in sorted(edges - missing))]))
    with pytest.warns(MeshNote) as notes, pytest.raises(InvalidMetric, match="faces may be missing between"):
        read_metric(path)
    assert sentence in str(notes[-1].message)
    hubs = re.findall(r"A\d+", str(notes[-1].message).split("are around")[0])
    assert len(hubs) == 3 + len(missing) and {*sum(missing, ())} <= {*hubs}


@pytest.mark.parametrize("shape", [dome(3), dome(4, -0.01), dome(3, -0.21), zoo.random_hull(30, 2)])
def test_a_table_that_was_written_is_read(shape, tmp_path):
    vertices, faces = shape
    own = surface(vertices, faces)
    strut_table(own).save(tmp_path / "a.csv")
    metric = read_metric(tmp_path / "a.csv", any_surface=True)
    np.testing.assert_array_equal(metric.edges, own.edges)
    np.testing.assert_allclose(metric.lengths, own.lengths, rtol=1e-11)
    assert {frozenset(face) for face in metric.faces.tolist()} == {frozenset(face) for face in faces.tolist()}
    assert metric.length_errors is None


@pytest.mark.parametrize(
    ("frequency", "decimals", "most"), [(2, 5, 2e-5), (3, 4, 2e-4), (4, 3, 2e-3), (8, 5, 2e-5), (6, 2, 2e-2)]
)
def test_closed_domes_by_the_digits_of_builders(frequency, decimals, most, tmp_path):
    vertices, faces = dome(frequency)
    path = written(tmp_path, typed(strut_table(surface(vertices, faces)), decimals))
    found = embed(path)
    assert found.status == "converged"
    np.testing.assert_allclose(found.length_errors, 10.0**-decimals / 12**0.5)
    assert farthest(found, vertices) < most


@pytest.mark.parametrize(
    ("frequency", "decimals", "most"), [(2, 5, 2e-5), (4, 3, 1e-3), (6, 5, 2e-5), (8, 2, 3e-2)]
)
def test_half_domes_by_the_digits_of_builders(frequency, decimals, most, tmp_path):
    vertices, faces = dome(frequency, -0.01)
    path = written(tmp_path, typed(strut_table(surface(vertices, faces)), decimals))
    found = embed(path, boundary="plane")
    assert found.converged and farthest(found, vertices) < most
    [rim] = found.triangulation.boundaries
    assert np.abs(found.vertices[rim, 2]).max() < 1e-12
    assert isoembed.report(found)["sheet"]["condition"] == "plane"


def test_more_than_half_a_sphere_is_no_cap(tmp_path):
    path = written(tmp_path, typed(strut_table(surface(*dome(3, -0.21))), 5))
    with pytest.raises(InvalidMetric, match=r"exterior angle of the boundary at vertex \d+ is -0\.037"):
        embed(path, boundary="plane")
    with pytest.warns(MeshNote, match="takes lengths as exact: the errors of their digits are unused"):
        assert embed(path, boundary="free").converged
    with pytest.raises(InvalidParameter, match="requires boundary='plane'"):
        embed(path, boundary="free", length_errors=1e-5)


def test_names_and_numbers_from_one(tmp_path):
    given = {(min(ends), max(ends)): 2 + 0.001 * k for k, ends in enumerate(OCTAHEDRON)}
    hubs = ["P0", "P2", "P10", "P11", "Q1", "q"]
    for names, note in (
        (range(6), None),
        (range(1, 7), ", ".join(f"hub {k + 1} is vertex {k}" for k in range(6))),
        (hubs, ", ".join(f"hub {hub} is vertex {k}" for k, hub in enumerate(hubs))),
    ):
        lines = [f"{names[b]},{names[a]},{length}\n" for (a, b), length in given.items()]
        path = written(tmp_path, "from,to,length\n" + "".join(lines[::-1]))
        with nullcontext() if note is None else pytest.warns(MeshNote, match=note):
            metric = read_metric(path)
        assert (metric.triangulation.n_faces, metric.length_errors) == (8, None)
        assert dict(zip(map(tuple, metric.edges.tolist()), metric.lengths.tolist(), strict=True)) == given


def test_spreadsheets_with_decimal_commas(tmp_path):
    edges = dome(2)[1]
    struts = [(a, b, "1,25" if a < 12 else "1,500") for a, b in edges_of(edges)]
    for row, header in (
        ("{0};{1};{2}\n", "\ufeffFrom;To;Length (m)\n"),
        ("{0}\t{1}\t{2}\n", "from\tto\tlength [m]\n"),
        ('"{0}","{1}","{2}"\n', "A survey,,\nfrom,to,length\n"),
        ("{0};{1};{2}\n;;\n\n", "\nfrom;to;length\n\n"),
    ):
        metric = read_metric(written(tmp_path, header + "".join(row.format(*strut) for strut in struts)))
        assert len(metric.lengths) == len(struts)
        assert sorted(set(metric.lengths.tolist())) == [1.25, 1.5]
        np.testing.assert_allclose(metric.length_errors, 0.01 / 12**0.5)


@pytest.mark.parametrize("column", ["length error", "Length_error (mm)", "sigma", "error"])
def test_a_column_of_errors(column, tmp_path):
    errors = {ends: 0.01 * (k + 1) for k, ends in enumerate(OCTAHEDRON)}
    table = "".join(f"{a},{b},2,{sigma}\n" for (a, b), sigma in errors.items())
    metric = read_metric(written(tmp_path, f"from,to,length,{column}\n{table}"))
    for ends, sigma in zip(metric.edges.tolist(), metric.length_errors, strict=True):
        assert sigma == errors.get(tuple(ends), errors.get(tuple(ends[::-1])))
    legend = "type,length,length error\nA,2,0.1\nB,3,0.2\n\n"
    kinds = "".join(f"{a},{b},{'AB'[a == 0]}\n" for a, b in OCTAHEDRON)
    metric = read_metric(written(tmp_path, f"{legend}from,to,type\n{kinds}"))
    np.testing.assert_array_equal(metric.length_errors, (metric.lengths - 1) / 10)


def test_tables_of_other_encodings(tmp_path):
    text = "from,to,length\n" + rows([(f"ü{a}", f"ü{b}") for a, b in OCTAHEDRON], 2)
    for encoding in ("utf-8", "utf-16", "latin-1"):
        path = tmp_path / "struts.csv"
        path.write_bytes(text.encode(encoding))
        with pytest.warns(MeshNote, match="hub ü0 is vertex 0, hub ü1 is vertex 1"):
            assert len(read_metric(path).lengths) == 12


def test_chord_factors_are_lengths(tmp_path):
    text = "# an octahedron\ntype,chord factor,color\nA,1.41421,red\n\nfrom,to,type\n" + rows(OCTAHEDRON, "A")
    assert read_metric(written(tmp_path, text)).lengths[0] == 1.41421


@pytest.mark.parametrize(
    ("lengths", "error"),
    [
        (("3", "4"), None),  # a design
        (("547", "618"), 1 / 12**0.5),
        ((".55", ".6"), 0.01 / 12**0.5),
        (("1.0", "1.0"), None),  # one length
        (("0.5465330581", "0.6180339887"), None),  # ten digits
        (("5.4653e-1", "6.1803e-1"), None),
    ],
)
def test_errors_by_the_digits(lengths, error, tmp_path):
    text = "from,to,length\n" + rows(OCTAHEDRON[:8], lengths[0]) + rows(OCTAHEDRON[8:], lengths[1])
    assert read_metric(written(tmp_path, text)).length_errors is None  # of a few struts, they are exact
    edges = edges_of(dome(2)[1])
    text = "from,to,length\n" + rows(edges[:80], lengths[0]) + rows(edges[80:], lengths[1])
    found = read_metric(written(tmp_path, text)).length_errors
    if error is None:
        assert found is None
    else:
        np.testing.assert_allclose(found, error)


def test_three_hubs_around_a_part_of_the_frame_are_no_face(tmp_path):
    bipyramid = [(0, 1), (1, 2), (2, 0), *((a, b) for a in (3, 4) for b in (0, 1, 2))]
    metric = read_metric(written(tmp_path, "from,to,length\n" + rows(bipyramid, 1)))
    assert metric.triangulation.n_faces == 6


@pytest.mark.parametrize(
    "text", ['"1,345.8"', '"1.345,8"', "1345.8 mm", '1345.8"', "1.3458D+03", '"1 345,8"', '"1\u202f345,8 cm"']
)
def test_lengths_as_spreadsheets_write_them(text, tmp_path):
    table = "from,to,length,error\n" + rows(OCTAHEDRON, text, 1)
    np.testing.assert_array_equal(read_metric(written(tmp_path, table)).lengths, 1345.8)


def test_struts_listed_by_each_of_their_faces(tmp_path):
    once = "from,to,length\n" + rows(OCTAHEDRON, "1.50")
    own = read_metric(written(tmp_path, once))
    twice = read_metric(written(tmp_path, once + rows([ends[::-1] for ends in OCTAHEDRON], "1.5")))
    np.testing.assert_array_equal(twice.faces, own.faces)
    np.testing.assert_array_equal(twice.lengths, own.lengths)


@pytest.mark.parametrize("finer_first", [False, True])
def test_of_two_equal_struts_the_one_with_more_digits_is_kept(finer_first, tmp_path):
    tables = rows(OCTAHEDRON, "34"), "".join(f"{b},{a},34.{k:02}\n" for k, (a, b) in enumerate(OCTAHEDRON))
    metric = read_metric(written(tmp_path, "from,to,length\n" + "".join(tables[:: -1 if finer_first else 1])))
    np.testing.assert_array_equal(np.sort(metric.lengths), 34 + np.arange(12) / 100)


@pytest.mark.parametrize(
    ("columns", "length", "error"),
    [
        ("length (mm),error", "1.5 mm", "0.1mm"),
        ("length [in],length error (inches)", '1.5"', "0.1"),
        ("length (as built),error", "1.5 m", "0.1"),
        ("length,error (m)", "1.5 m", "0.1"),
        ("length,error,unit", "1.5", "0.1;Meters"),
        ("length (m),error,unit", "1.5", "0.1;"),
    ],
)
def test_units_that_agree(columns, length, error, tmp_path):
    table = "".join(f"{a};{b};{length};{error}\n" for a, b in OCTAHEDRON)
    metric = read_metric(written(tmp_path, f"from;to;{columns.replace(',', ';')}\n{table}"))
    assert set(metric.lengths.tolist()) == {1.5} and set(metric.length_errors.tolist()) == {0.1}


def test_numbers_of_pieces_are_no_units(tmp_path):
    table = "".join(f"{a},{b},1.5,{a + b}\n" for a, b in OCTAHEDRON)
    metric = read_metric(written(tmp_path, f"from,to,length,units\n{table}"))
    assert set(metric.lengths.tolist()) == {1.5}


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("", FileError, "is not a strut table: it has no rows below a line with 'from', 'to'"),
        ("a,b\n1,2\n", FileError, "is not a strut table"),
        ("from,to,length\n0,1," + 200_000 * "1" + "\n", FileError, "line 2: field larger than field limit"),
        ("from,to,length\n0,1,x\n", FileError, "line 2: the length is 'x', not a positive finite number"),
        ("from,to,length\n0,1,-1\n", FileError, "line 2: the length is '-1', not a positive finite number"),
        ("from,to,type\n0,1,A\n", FileError, "line 2: the strut has no length, and its type 'A' has none"),
        ("type,length\nA,0\n\nfrom,to,type\n0,1,A\n", FileError, "line 2: the length is '0'"),
        (
            "from,to,length\n0,1,3,125\n",
            FileError,
            "line 2: there are 4 cells below 3 columns; a decimal comma",
        ),
        (
            "from;to;length\n0;1;3,125 ft\n",
            FileError,
            "line 2: the length is '3,125 ft', not a positive finite number: what 'ft' means is unclear",
        ),
        (
            "from,to,length\n0,1,3 mm\n1,2,3 cm\n",
            FileError,
            "line 3: the length is '3 cm', but '3 mm' in line 2: all lengths need the same unit, or none",
        ),
        ("from,to,length\n0,1,3 1/2\n", FileError, "'3 1/2', not .* write fractions as decimals, 3.5$"),
        ("from,to,length\n0,1,14-11/16 in\n", FileError, "write fractions as decimals, 14.6875$"),
        ("from,to,length\n0,1,3/8\n", FileError, "'3/8', .* write fractions as decimals, 0.375$"),
        ("from,to,length\n0,1,3 1/0\n", FileError, "what '1/0' means is unclear"),
        (
            "from,to,length\n0,1,15dm\n",
            FileError,
            "line 2: the length is '15dm', .* what 'dm' means is unclear",
        ),
        (
            "from,to,length (mm)\n0,1,12 in\n",
            FileError,
            r"line 2: the length is '12 in' in the column 'length \(mm\)'",
        ),
        (
            "type,length (m)\nA,3\n\nfrom,to,type,length (ft)\n0,1,A,\n1,2,,9\n",
            FileError,
            "line 6: the length is '9 ft', but '3 m' in line 2: all lengths need the same unit",
        ),
        (
            "type,length (in)\nA,3\n\nfrom,to,type,length\n0,1,A,\n1,2,,76\n",
            FileError,
            "line 6: the length is '76', but '3 in' in line 2: all lengths need the same unit",
        ),
        (
            "from,to,length,unit\n0,1,76,mm\n1,2,3,in\n",
            FileError,
            "line 3: the length is '3 in', but '76 mm' in line 2: all lengths need the same unit",
        ),
        (
            "from,to,length,unit\n0,1,76,mm\n1,2,3,\n",
            FileError,
            "line 3: the length is '3', but '76 mm' in line 2: all lengths need the same unit",
        ),
        (
            "from,to,length (mm),unit\n0,1,3,in\n",
            FileError,
            "line 2: the length is '3 mm', and its unit 'in'",
        ),
        (
            "from,to,length\n0,1,3\n1,0,3.40\n",
            FileError,
            "line 3: .* 1 and 0 are 3.40 apart, but 3 in line 2",
        ),
        (
            'from,to,length\n0,1,"1,250"\n1,2,881\n',
            FileError,
            "line 2: the length '1,250' may be 1250 or 1.250",
        ),
        (
            "from;to;length\n0;1;1,250\n1;2;1,881\n2;0;965\n",
            FileError,
            "line 4: the length '965' has no decimal comma, as most lengths have",
        ),
        ("from,to,length,error\n0,1,1,\n0,2,1,.1\n1,2,1,.1\n", FileError, "line 2: the length error is ''"),
        ("type,length,color\n2\n,2\n\nfrom,to,type\n0,1\n", FileError, "its type '' has none"),
        ("from,length,to\n0,1\n", FileError, "line 2: a strut is from '0' to ''"),
        ("von;nach;mm\n0;1;2\n", FileError, "its first line is 'von;nach;mm'"),
        ("from,to,length\n0,0,1\n", FileError, "line 2: a strut is from '0' to '0'"),
        (
            "from,to,length\n0,1,1.0\n1,0,1.1\n",
            FileError,
            "line 3: the hubs 1 and 0 are 1.1 apart, but 1.0 in line 2",
        ),
        ("from,to,length\n0,1,1\n1,2,1\n", InvalidMetric, "between the hubs 0 and 1 is in no triangle"),
        ("from,to,length\n1,2,1\n\n2,3,1\n", InvalidMetric, "between the hubs 1 and 2 is in no triangle"),
        (
            "from,to,length\nb,a,60\ntop,a,162\ntop,b,70\nc,a,90\nc,b,90\nc,top,90\n",
            InvalidMetric,
            "the hubs a, b, top breaks the triangle inequality: a to top is 162, b to top is 70, a to b is",
        ),
        ("from,to,length\nb,a,1\na,c,1\n", InvalidMetric, "between the hubs b and a is in no triangle"),
        (
            "from;to;long\n0;1;2\n",
            FileError,
            "line 2: no 'length' or 'type' is among the columns from, to, long",
        ),
        (
            "from,to,length\n" + rows([(a, b) for b in range(5) for a in range(b)], 1),
            InvalidMetric,
            "between the hubs 0 and 1 is in 3 triangles: give the faces",
        ),
    ],
)
def test_what_is_wrong_with_a_table(text, error, words, tmp_path):
    with pytest.raises(error, match=words):
        read_metric(written(tmp_path, text), any_surface=True)


@pytest.mark.parametrize(
    ("columns", "length", "error", "words"),
    [
        ("length,error", "1.50 m", "0.5 mm", "error is '0.5 mm', and the length '1.50 m': units differ"),
        ("length,error", "1.50 m", "5 cm", "error is '5 cm', and the length '1.50 m': units differ"),
        ("length,error", "1.50", "5 cm", "error is '5 cm', and the length '1.50': units differ"),
        ("length (m),error (mm)", "1.50", "5", "error is '5 mm', and the length '1.50 m': units differ"),
        ("length,error (mm)", "1.50", "5 cm", r"error is '5 cm' in the column 'error \(mm\)'"),
        ("length,error", "1.50 m", "5 µm", "error is '5 µm', .* what 'µm' means is unclear"),
    ],
)
def test_errors_in_another_unit_than_their_lengths(columns, length, error, words, tmp_path):
    with pytest.raises(FileError, match=f"line 2: the length {words}"):
        read_metric(written(tmp_path, f"from,to,{columns}\n{rows(OCTAHEDRON, length, error)}"))


@pytest.mark.parametrize("error", ["", "0.01"])
def test_a_mistyped_strut_is_named_by_its_hubs(error, tmp_path):
    """Whether the lengths have errors, by their digits or a column, or not."""
    own = surface(*dome(4))
    lengths = [f"{100 * length:.2f}" for length in own.lengths]
    lengths[100] = "3249"  # 32.49, without its point
    (a, b), names = own.edges[100], [f"{'ABCDEFGH'[v // 50]}{v % 50 + 10}" for v in range(len(own.vertices))]
    table = "".join(
        f"{names[a]},{names[b]},{length},{error}\n" for (a, b), length in zip(own.edges, lengths, strict=True)
    )
    said = f"wrong, it is that of the strut {names[a]} to {names[b]}: 3249 where about 32.* typed for 32.49"
    with pytest.raises(
        InvalidMetric, match=f"the triangle of the hubs .* is 3249, .*; if one length is {said}$"
    ):
        read_metric(written(tmp_path, "from,to,length,error\n" + table))


def test_larger_errors_than_those_of_the_digits_explain_a_triangle(tmp_path):
    own = surface(*zoo.random_hull(60, 6))
    lengths = np.round(100 * own.lengths, 1)
    sides = own.triangulation.face_edges[0]
    lengths[sides[0]] = np.round(lengths[sides[1:]].sum(), 1) + 0.9
    text = "from,to,length\n" + "".join(
        f"{a},{b},{length:.1f}\n" for (a, b), length in zip(own.edges, lengths, strict=True)
    )
    with pytest.raises(InvalidMetric, match=r"the triangle of the hubs .* breaks the triangle inequality"):
        read_metric(written(tmp_path, text))
    with pytest.warns(MeshNote, match="changed within their errors"):
        read_metric(written(tmp_path, text), length_errors=0.5)


def test_no_single_strut_is_named_where_a_type_may_be_wrong(tmp_path):
    """A pyramid whose base is of a type with a tenth of its length: the diagonal is right."""
    legend = "type,length\nA,1\nB,.1\nC,1.4\n"
    struts = "from,to,type\n" + "".join(f"{k},5,A\n{k},{k % 4 + 1},B\n" for k in range(1, 5)) + "1,3,C\n"
    with pytest.raises(InvalidMetric, match=r"breaks the triangle inequality: [^;]*$"):
        read_metric(written(tmp_path, legend + struts))
