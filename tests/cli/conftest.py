"""The command, called in an empty folder."""

import os

import pytest

from isoembed.cli import main
from strict_json import strict


@pytest.fixture
def call(tmp_path, monkeypatch, capfd):
    """Call the command; return its status, its output and its complaint."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        before = set(os.listdir())
        status = main([*map(str, arguments)])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        if status == 2:
            assert set(os.listdir()) == before
            assert out == "" and err.startswith("isoembed: error: ") and err.count("\n") == 1
        return status, out, err

    return call


@pytest.fixture
def report(call):
    """Call ``isoembed energy --json`` where it succeeds; return the object."""

    def report(*arguments):
        status, out, err = call("energy", *arguments, "--json")
        assert (status, err) == (0, "")
        return strict(out)

    return report
