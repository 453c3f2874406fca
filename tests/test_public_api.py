"""What is public changes only where it is meant to."""

import enum
import re
import subprocess
import sys
from pathlib import Path

import pytest

import isoembed
import public_api
from public_api import KEPT, changes, lines, parameters

UPDATE = "If that is meant, say it in CHANGELOG.md and run: python tests/support/public_api.py"


def test_names_and_parameters_are_those_that_were_promised():
    told = list(changes(KEPT.read_text(encoding="utf-8").splitlines(), list(lines())))
    assert not told, "\n".join(["what is public has changed:", *told, UPDATE])


@pytest.mark.parametrize("package", ["", "plot/", "relativity/"])
def test_what_is_imported_on_first_use_has_no_name_of_a_module(package):
    stub = Path(isoembed.__file__).parent / package / "__init__.pyi"
    found = re.findall(r"from \.(\S*) import (\w+) as (\w+)", stub.read_text(encoding="utf-8"))
    assert len(found) > 10
    for module, name, known in found:
        assert name == known
        shadowed = [stub.parent / name, (stub.parent / name).with_suffix(".py")]
        assert not module or not any(map(Path.exists, shadowed)), f"{name}: once imported, it is the module"


def test_changes_are_told():
    kept = ["a.gone(x)", "class a.C(x, y=1)", "a.C.area", "a.same"]
    now = ["class a.C(x, y=2)", "a.C.area(self)", "a.new", "a.same"]
    assert list(changes(kept, now)) == [
        "a.gone is gone",
        "a.new is new",
        "class a.C(x, y=1) has become class a.C(x, y=2)",
        "a.C.area has become a.C.area(self)",
    ]


def test_types_are_not_part_of_a_line():
    def function(a: int, *, b: "float" = 1.5, c: object = enum, **rest: int) -> None: ...

    assert parameters(function) == "(a, *, b=1.5, c=..., **rest)"


def test_a_class_is_described_with_what_it_inherits(monkeypatch):
    monkeypatch.setattr(public_api, "names", lambda: ["isoembed.FittedSurface", "isoembed.ConvexPolyhedron"])
    described = list(lines())
    assert described[0].startswith("class isoembed.FittedSurface(")
    assert "isoembed.ConvexPolyhedron.volume" in described  # of Embedding
    assert not any("._" in line for line in described)


@pytest.mark.parametrize("name", ["isoembed.embed", "isoembed.relativity.KerrNewmanHorizon"])
def test_public_names_are_among_them(name):
    assert name in public_api.names()


def test_packages_are_loaded_on_first_use():
    # Lower packages first: none is loaded by those before it.
    code = """if True:
        import sys, isoembed
        for package in "progress", "gallery", "io", "smooth", "relativity", "plot", "papercraft":
            name = "isoembed." + package
            assert name not in sys.modules, name
            assert getattr(isoembed, package).__name__ == name
    """
    subprocess.run([sys.executable, "-c", code], check=True)
