"""What names of files say, and patterns of them."""

import pytest

from isoembed.errors import InvalidParameter
from isoembed.relativity.series.file_names import NameParts, matching_files, name_parts


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("run/AhA_0012.vtk", NameParts("AhA", 12)),
        ("h.t1024.ah1.gp.gz", NameParts("h.ah1", 1024)),
        ("surface01_00000000.vtk.gz", NameParts("surface01", 0)),
        ("ah1.npz", NameParts("ah1")),
        ("ah1", NameParts("ah1")),
        ("gxx.1024.h5", NameParts("gxx", 1024)),
        ("gxx.10.5.h5", NameParts("gxx", None, 10.5)),
        ("gxx-t0.125.h5", NameParts("gxx", None, 0.125)),
        ("gxx_time=3.h5", NameParts("gxx", None, 3.0)),
        ("AhC-it=64.npz", NameParts("AhC", 64)),
        ("2.5e-1.npz", NameParts("", None, 0.25)),
        ("2026-11-22_AhA.007.npz", NameParts("2026-11-22_AhA", 7)),
    ],
)
def test_names(name, parts):
    assert name_parts(name) == parts


@pytest.mark.parametrize(
    ("pattern", "names"),
    [
        ("gxx.{iteration}.h5", ["gxx.000012.h5", "gxx.12.h5", "gxx.7.h5"]),
        ("gxx.{iteration:06d}.h5", ["gxx.000012.h5"]),
        ("gxx.{iteration:d}.h5", ["gxx.12.h5", "gxx.7.h5"]),
        ("gxx.{time}.h5", ["gxx.-0.5.h5", "gxx.000012.h5", "gxx.1.5e+2.h5", "gxx.12.h5", "gxx.7.h5"]),
        ("gxx.{time:.1f}.h5", ["gxx.-0.5.h5"]),
        ("it{iteration}/t{time}[0].h5", ["it4/t0.5[0].h5"]),
        ("gyy.{iteration}.h5", []),
    ],
)
def test_patterns(tmp_path, pattern, names):
    for name in ("gxx.12.h5", "gxx.000012.h5", "gxx.7.h5", "gxx.-0.5.h5", "gxx.1.5e+2.h5", "gxx.a.h5"):
        (tmp_path / name).touch()
    (tmp_path / "it4").mkdir()
    (tmp_path / "it4" / "t0.5[0].h5").touch()
    found = matching_files(f"{tmp_path}/{pattern}")
    assert [path.removeprefix(f"{tmp_path}/") for path, _, _ in found] == names


def test_numbers_of_a_pattern(tmp_path):
    (tmp_path / "a_0064_0.250.h5").touch()
    (found,) = matching_files(str(tmp_path / "a_{iteration:04d}_{time:.3f}.h5"))
    assert found[1:] == (64, 0.25)


@pytest.mark.parametrize(
    ("pattern", "sentence"),
    [
        (
            "a.{it}.h5",
            r"the pattern a\.\{it\}\.h5 has the field \{it\}: it may have \{iteration\} and \{time\}",
        ),
        ("a.{}.h5", r"has the field \{\}"),
        ("a.{time}{time}.h5", r"has the field \{time\}: .* once each"),
        ("a.{time", r"the pattern a\.\{time: expected '\}' before end of string"),
        ("a.{iteration:.3q}", r"the pattern a\.\{iteration:\.3q\}: .*"),
    ],
)
def test_patterns_that_are_none(pattern, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        matching_files(pattern)
