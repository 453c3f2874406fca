"""The README and the pages of docs/ are whole: links lead on, every name and option has its place."""

import argparse
import importlib
import importlib.util
import inspect
import re
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import isoembed
from isoembed.cli import COMMANDS, build_parser
from pages import ALIKE, DOCS, PAGES, PICTURE, blocks, difference
from places import ROOT

LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")

DOCUMENTED = [
    "isoembed",
    *(
        f"isoembed.{room}"
        for room in (
            "gallery",
            "gluing",
            "io",
            "linalg",
            "meshing",
            "plot",
            "plot.series",
            "relativity",
            "smooth",
        )
    ),
]
"""The rooms that say what is public in ``__all__``."""


def test_there_is_code_to_run():
    languages = [language for page in PAGES for language, _, _ in blocks(page)]
    assert languages.count("python") >= 4
    assert languages.count("console") >= 3


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_links_lead_to_files(page):
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if not target.startswith(("https:", "mailto:")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_every_picture_of_the_gallery_is_made_and_small():
    names = PICTURE.findall((DOCS / "gallery.md").read_text(encoding="utf-8"))
    kept = sorted((DOCS / "images" / "gallery").iterdir())
    assert sorted(DOCS / name for name in names) == kept and len(kept) >= 8
    assert max(file.stat().st_size for file in kept) < 150_000


def test_another_picture_is_not_alike():
    folder = DOCS / "images" / "gallery"
    pictures = [Image.open(file).convert("RGB") for file in sorted(folder.iterdir())]
    for picture, other in pairwise(pictures):
        assert difference(picture, picture) == 0
        assert difference(picture, picture.transpose(Image.Transpose.FLIP_LEFT_RIGHT)) > 2 * ALIKE
        assert difference(picture, other.resize(picture.size)) > 2 * ALIKE
    assert difference(pictures[0], pictures[0].reduce(2)) == 1.0


def test_the_colors_of_a_picture_count():
    from isoembed.gallery import Ellipsoid, triangulate
    from isoembed.plot import figure

    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 800))
    surface = isoembed.embed(metric)
    drawn = figure(surface, color="Gaussian curvature")
    drawn.set_dpi(220)
    drawn.canvas.draw()
    with Image.open(DOCS / "images" / "gallery" / "ellipsoid.png") as kept:
        assert difference(kept, Image.fromarray(np.asarray(drawn.canvas.buffer_rgba()))) > 2 * ALIKE


@pytest.mark.parametrize("room", DOCUMENTED)
def test_every_public_name_has_its_place_in_the_reference(room):
    text = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.md"))
    named = set(re.findall(r"^\.\. auto\w+:: (\S+)$", text, re.MULTILINE))
    module = importlib.import_module(room)
    missing = []
    for name in module.__all__:
        if inspect.ismodule(getattr(module, name)):  # it has a page of its own
            continue
        home = getattr(getattr(module, name), "__module__", room)
        aliases = {f"{place}.{name}" for place in (room, home, home.rpartition(".")[0], "isoembed")}
        if not aliases & named and not name.startswith("__"):
            missing.append(name)
    assert not missing
    for target in named:
        home, _, name = target.rpartition(".")
        assert hasattr(importlib.import_module(home), name), target


def test_every_page_is_in_the_table_of_contents():
    listed = set()
    for page in DOCS.glob("**/*.md"):
        for language, _, text in blocks(page):
            if language == "{toctree}":
                entries = [line for line in text.splitlines() if line and not line.startswith(":")]
                listed |= {(page.parent / entry).relative_to(DOCS).as_posix() for entry in entries}
    pages = {file.relative_to(DOCS).with_suffix("").as_posix() for file in DOCS.glob("**/*.md")}
    tutorials = {f"tutorials/{file.stem}" for file in (DOCS / "tutorials").glob("*.ipynb")}
    assert listed == (pages | tutorials) - {"index"}


def reference(command):
    """What docs/command-line.md says of a command, there and where it refers to for the options."""
    text = (DOCS / "command-line.md").read_text(encoding="utf-8")
    parts = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
    own = "".join(part for part in parts if re.search(rf"`isoembed {command}\b", part.splitlines()[0]))
    assert own, f"docs/command-line.md has no section on {command}"
    if "| option |" not in own:
        pages = {DOCS / page for page in LINK.findall(own) if not page.startswith("https:")}
        own += "".join(page.read_text(encoding="utf-8") for page in sorted(pages))
    elsewhere = [reference(other) for other in re.findall(r"\(#isoembed-(\w+)\)", own)]
    return own + "".join(elsewhere)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_of_a_command_is_in_its_reference(command):
    (subparsers,) = (
        action
        for action in build_parser([command])._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    strings = [action.option_strings for action in subparsers.choices[command]._actions]
    said = set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", reference(command)))
    missing = [names for names in strings if names and "--help" not in names and not said & set(names)]
    assert not missing, f"isoembed {command}: not in docs/command-line.md"


def test_the_citation_is_that_of_the_repository():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    page = (DOCS / "citing.md").read_text(encoding="utf-8")
    assert f"version = {{{isoembed.__version__}}}" in page
    for pattern in (r"title: (Adiabatic.*)", r"volume: (\d+)", r'start: "(\d+)"', r"value: arXiv:(\S+)"):
        (found,) = re.findall(pattern, citation)
        assert found in page.replace("{Euclidean}", "Euclidean")
    for family in re.findall(r"family-names: (\w+)", citation):
        assert f"{family}, " in page


def test_the_tables_of_thresholds_are_those_of_the_code():
    spec = importlib.util.spec_from_file_location("thresholds_of_the_docs", DOCS / "thresholds.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for page in module.PAGES:
        text = page.read_text(encoding="utf-8")
        assert module.current(text) == text, f"{page.name}: run python docs/thresholds.py"
    names = [name for _, name, _ in module.everywhere()]
    assert len(names) > 20 and len(set(names)) == len(names)
