"""Who watches is told of the compilation of functions; who does not, is not."""

import sys

import pytest
from numba import njit

import isoembed.kernel.compiler  # noqa: F401 -- numba's events are heard
from isoembed.cli import compilation
from isoembed.cli.compilation import compilation_said

SENTENCE = "isoembed: note: functions are being compiled, once, which takes some seconds\n"


def compile_two():
    for _ in range(2):
        njit(lambda x: x + 1)(1)


@pytest.fixture
def said(monkeypatch, capsys):
    """What is said while a block runs."""

    def said(work, quiet=False, *, terminal=True, patience=0.0):
        monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
        monkeypatch.setattr(compilation, "PATIENCE", patience)
        with compilation_said(quiet):
            work()
        return capsys.readouterr().err

    return said


def test_it_is_said_once_on_a_terminal(said, capsys):
    assert said(lambda: (compile_two(), compile_two())) == SENTENCE
    compile_two()  # nobody listens any more
    assert capsys.readouterr().err == ""


def test_it_is_not_said(said):
    assert said(compile_two, quiet=True) == ""
    assert said(compile_two, patience=1e3) == ""
    assert said(compile_two, terminal=False) == ""


def test_nothing_is_said_where_nothing_is_compiled(said):
    compiled = njit(lambda x: x + 1)
    compiled(1)
    assert said(lambda: compiled(2)) == ""
