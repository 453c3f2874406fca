"""The README and the pages of docs/ are whole: links lead on, every name and option has its place."""

import argparse
import ast
import importlib
import importlib.util
import inspect
import json
import pkgutil
import re
from itertools import pairwise
from urllib.parse import urlsplit

import numpy as np
import pytest
from markdown_it import MarkdownIt
from PIL import Image

import isoembed
from isoembed.cli import COMMANDS, build_parser
from page_blocks import blocks
from pages import ALIKE, DOCS, PAGES, PICTURE, difference
from places import ROOT

LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
ANCHORED = re.compile(r"\]\(([^)#\s]*)#([^)\s]+)\)")
EXTERNAL = re.compile(r"\bhttps?:[^\s)>\"'\\]*")
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)

HOSTS = {
    "arxiv.org",
    "docs.dask.org",
    "doi.org",
    "geometry-central.net",
    "github.com",
    "mpi4py.readthedocs.io",
    "packaging.python.org",
    "sbozzolo.github.io",
    "scientific-python.org",
}
"""All hosts that pages link to: a new one is looked at once."""

PACKAGES = [found.name for found in pkgutil.walk_packages(isoembed.__path__, "isoembed.") if found.ispkg]
DOCUMENTED = [name for name in ("isoembed", *PACKAGES) if hasattr(importlib.import_module(name), "__all__")]
"""The packages that say what is public in ``__all__``."""


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


def texts():
    """(page, text) of everything that people read: tutorials in their Markdown cells."""
    for page in [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]:
        yield page, page.read_text(encoding="utf-8")
    for page in sorted((DOCS / "tutorials").glob("*.ipynb")):
        cells = json.loads(page.read_text(encoding="utf-8"))["cells"]
        yield page, "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def spans(text):
    """The code spans that the author of a page meant, and those that Markdown makes of it, spaces made one.

    A line that happens to begin with + or - is a list, and cuts the code span in which it stands.
    """
    bare = re.sub(r"^```.*?^```$|^ {4}[^\n]*$", "", text, flags=re.MULTILINE | re.DOTALL)
    meant = [" ".join(span[1].split()) for span in re.finditer(r"(?<!`)`([^`]+)`(?!`)", bare)]
    tokens = MarkdownIt("commonmark").enable("table").parse(bare)
    made = [part.content for token in tokens for part in token.children or () if part.type == "code_inline"]
    return [span.replace("\\|", "|") for span in meant], [" ".join(span.split()) for span in made]


@pytest.mark.parametrize(("page", "text"), list(texts()), ids=lambda value: getattr(value, "name", ""))
def test_code_spans_are_rendered_whole(page, text):
    meant, made = spans(text)
    assert meant == made


def test_a_code_span_that_a_list_cuts_is_seen():
    meant, made = spans("The trace is `k = k1\n+ k2`.\n")
    assert meant == ["k = k1 + k2"] and made == []


def anchors(text):
    """The anchors that GitHub and the site make of headings."""
    bare = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    words = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in HEADING.findall(bare)]
    return {re.sub(r"[^\w\- ]", "", word).strip().replace(" ", "-") for word in words}


@pytest.mark.parametrize(("page", "text"), list(texts()), ids=lambda value: getattr(value, "name", ""))
def test_anchors_are_those_of_headings(page, text):
    for target, anchor in ANCHORED.findall(text):
        if not target.startswith("https:"):
            other = page.parent / target if target else page
            assert other.exists() and anchor in anchors(dict(texts())[other.resolve()]), f"{target}#{anchor}"


def test_external_links_are_whole_and_lead_to_known_hosts():
    hosts = set()
    for page, text in texts():
        bare = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
        for link in EXTERNAL.findall(bare):
            parts = urlsplit(link)
            assert parts.scheme == "https" and re.fullmatch(r"[\w.-]+\.\w+", parts.netloc), (page.name, link)
            assert not link.endswith((".", ",", ";")), (page.name, link)
            hosts.add(parts.netloc)
    assert hosts - {"keepachangelog.com", "semver.org"} == HOSTS


@pytest.fixture(scope="module")
def reference_names():
    """What has a place on the API pages."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.md"))
    return set(re.findall(r"^\.\. auto\w+:: (\S+)$", text, re.MULTILINE))


def is_documented(names, place, name):
    """Whether a name that can be imported from a place is on an API page, there or where it is at home."""
    home = getattr(getattr(importlib.import_module(place), name), "__module__", place)
    return bool({f"{where}.{name}" for where in (place, home, home.rpartition(".")[0], "isoembed")} & names)


@pytest.mark.parametrize("package", DOCUMENTED)
def test_every_public_name_has_its_place_in_the_reference(package, reference_names):
    module = importlib.import_module(package)
    for name in module.__all__:
        has_page = inspect.ismodule(getattr(module, name))
        assert has_page or name.startswith("__") or is_documented(reference_names, package, name), name


def test_the_reference_has_no_name_that_is_gone(reference_names):
    for target in reference_names:
        home, _, name = target.rpartition(".")
        assert hasattr(importlib.import_module(home), name), target


def test_what_pages_and_examples_import_is_in_the_reference(reference_names):
    code = [text for page in PAGES for language, _, text in blocks(page) if language == "python"]
    code += [file.read_text(encoding="utf-8") for file in (DOCS / "examples").glob("*/*.py")]
    imports = [
        node
        for text in code
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.ImportFrom) and node.module.startswith("isoembed")
    ]
    missing = set()
    for place, name in ((node.module, alias.name) for node in imports for alias in node.names):
        found = getattr(importlib.import_module(place), name, None)
        if not (found is None or inspect.ismodule(found) or is_documented(reference_names, place, name)):
            missing.add(f"{place}.{name}")
    assert not missing


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


def reference_pages():
    """The pages of the last table of contents of the first page, and those of docs/api/."""
    *_, (caption, text) = re.findall(
        r"^:caption: (\w+)\n\n(.*?)^```", (DOCS / "index.md").read_text(), re.MULTILINE | re.DOTALL
    )
    assert caption == "Reference"
    return {DOCS / f"{entry}.md" for entry in text.split()} | set((DOCS / "api").glob("*.md"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_that_are_read_from_end_to_end_are_short(page):
    assert page in reference_pages() or len(page.read_text(encoding="utf-8").split()) <= 2500


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
    said |= {"--help", "--help-all", "--quiet"}  # which all have
    missing = [names for names in strings if names and not said & set(names)]
    assert not missing, f"isoembed {command}: not in docs/command-line.md"


def test_the_citation_is_that_of_the_repository():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    page = (DOCS / "citing.md").read_text(encoding="utf-8")
    for pattern in (r"title: (Adiabatic.*)", r"volume: (\d+)", r'start: "(\d+)"', r"value: arXiv:(\S+)"):
        (found,) = re.findall(pattern, citation)
        assert found in page.replace("{Euclidean}", "Euclidean")
    for family in re.findall(r"family-names: (\w+)", citation):
        assert f"{family}, " in page


def test_the_tables_of_thresholds_are_those_of_the_code():
    spec = importlib.util.spec_from_file_location("thresholds_of_the_docs", DOCS / "thresholds.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text = module.PAGE.read_text(encoding="utf-8")
    assert module.current(text) == text, "run python docs/thresholds.py"
    names = [name for _, name, _ in module.everywhere()]
    assert "MERGING" in names and len(set(names)) == len(names)
