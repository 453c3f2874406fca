"""Build the core alone, without the packages above it, and run its tests.

    python release/core.py [pytest options]

A second distribution could be cut along this line.  The packages in `ABOVE` are left out of the sources, the
wheel of the rest is installed into a fresh environment, and the tests of its packages are run.  Test files
that import a package left out, themselves or through `tests/support`, are counted and not run.
"""

import ast
import shutil
import sys
import tempfile
import tomllib
from functools import cache
from pathlib import Path

from check import ROOT, environment, run

ABOVE = ("autodiff", "cli", "papercraft", "plot", "relativity", "runs", "struts")
BY_NAME = (
    "aim/test_resuming.py::test_control_c_leaves_a_checkpoint_in_a_real_process",  # the command
    "gluing/test_unfolding.py::test_faces_of_rounded_solids_stay_whole",  # SVG
    "io/test_drawn_net.py::test_the_solid_comes_back_from_the_file",
    "io/test_drawn_net.py::test_solids_with_rounded_coordinates_come_back_with_their_faces",
    "io/test_registry.py::test_formats_of_installed_packages",  # the command
    "sheets/test_sheet.py::test_pictures_and_pages",  # pictures
)
"""Tests that need a package left out without importing it."""
SUPPORT = ROOT / "tests" / "support"


def imported(path: Path) -> set[str]:
    """Names of the modules that a file imports anywhere."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


@cache
def needs_more(path: Path) -> bool:
    """Whether a test or support file needs packages that are left out."""
    names = imported(path)
    above = {f"isoembed.{package}" for package in ABOVE}
    if any(".".join(name.split(".")[:2]) in above for name in names):
        return True
    helpers = (SUPPORT / f"{name}.py" for name in names)
    return any(needs_more(helper) for helper in helpers if helper.is_file() and helper != path)


def copied(folder: Path) -> tuple[Path, list[Path], int]:
    """Copy the sources of the core; return them, the test files that run, and the number of others."""
    packages = {path.name for path in (ROOT / "src/isoembed").iterdir() if path.is_dir()} - set(ABOVE)
    kept, left_out = [], 0
    for name in map(Path, run("git", "ls-files").splitlines()):
        if name.parts[:2] == ("src", "isoembed") and name.parts[2] in (*ABOVE, "__main__.py"):
            continue
        if name.parts[0] == "tests" and name.parts[1] != "support" and name.name.startswith("test_"):
            if name.parts[1] not in packages:
                continue
            if needs_more(ROOT / name):
                left_out += 1
                continue
            kept.append(name)
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target)
    project = folder / "pyproject.toml"
    text = project.read_text(encoding="utf-8")
    scripts = tomllib.loads(text)["project"]["scripts"]
    for name, target in scripts.items():  # the command is above the core
        text = text.replace(f'{name} = "{target}"\n', "")
    project.write_text(text, encoding="utf-8")
    if (ROOT / "build/compiled").is_dir():  # what was compiled before
        shutil.copytree(ROOT / "build/compiled", folder / "build/compiled")
    return folder, kept, left_out


def main() -> None:
    """Build, install, test."""
    with tempfile.TemporaryDirectory() as temporary:
        sources, tests, left_out = copied(Path(temporary) / "core")
        lines = sum(len(p.read_bytes().splitlines()) for p in (sources / "src").rglob("*.py"))
        print(f"core: {lines:,} lines; {len(tests)} test files, {left_out} others need more", flush=True)
        programs = environment(Path(temporary) / "environment")
        run(programs / "python", "-m", "pip", "install", "--quiet", ".[test]", folder=sources)
        shutil.rmtree(sources / "src")  # the installed core, not its sources
        without = [f"--deselect=tests/{name}" for name in BY_NAME]
        pytest = programs / "python", "-m", "pytest", "-q", *without
        print(run(*pytest, *sys.argv[1:], *tests, folder=sources), end="")


if __name__ == "__main__":
    main()
