"""What is public is enough to reproduce the paper, and what does so is no part of the package."""

import ast

import isoembed
import public_api
from places import ROOT


def imported(file):
    """The names of isoembed that a module imports."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == "isoembed":
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "isoembed")


def test_only_public_names_are_imported():
    files = sorted((ROOT / "reproduction").rglob("*.py"))
    used = {name for file in files for name in imported(file)}
    assert len(files) > 20 and "isoembed.embed" in used
    assert used <= set(public_api.names())


def test_the_package_has_neither_a_room_nor_a_command_for_it():
    from isoembed.cli import COMMANDS

    assert "reproduce" not in COMMANDS
    for file in (ROOT / "src" / "isoembed").rglob("*.py"):
        assert "import reproduction" not in (text := file.read_text(encoding="utf-8")), file
        assert "from reproduction" not in text, file
    assert not hasattr(isoembed, "studies")
