"""What is public changes only where it is meant to."""

import enum

import pytest

import public_api
from public_api import KEPT, changes, lines, parameters

UPDATE = "If that is meant, say it in CHANGELOG.md and run: python tests/support/public_api.py"


def test_names_and_parameters_are_those_that_were_promised():
    told = list(changes(KEPT.read_text(encoding="utf-8").splitlines(), list(lines())))
    assert not told, "\n".join(["what is public has changed:", *told, UPDATE])


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
