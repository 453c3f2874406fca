"""Every short example has its place on the page of examples, checks what it found and draws its picture."""

import ast
import importlib.util
import re
import sys

import numpy as np
import pytest
from PIL import Image

from page_blocks import blocks
from pages import DOCS


def loaded(name, path):
    """A module that is no part of a package."""
    spec = importlib.util.spec_from_file_location(name, path)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


EXAMPLES = loaded("drawing", DOCS / "examples" / "drawing.py").examples()
each = pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: f"{example.topic}/{example.name}")


def test_every_example_is_on_the_page_of_its_topic():
    listed, pages = [], sorted((DOCS / "examples").glob("*.md"))
    for page in pages:
        ((language, _, text),) = blocks(page)
        assert language == f"{{examples}} {page.stem}"
        listed += [f"{page.stem}/{name}" for name in text.split()]
    overview = re.findall(r"^```\{thumbnails\} (\w+)$", (DOCS / "examples.md").read_text(), re.MULTILINE)
    assert sorted(overview) == [page.stem for page in pages]
    assert sorted(listed) == [f"{example.topic}/{example.name}" for example in EXAMPLES]
    assert len({example.name for example in EXAMPLES}) == len(EXAMPLES)


@each
def test_an_example_is_short_and_checks_what_it_found(example):
    assert 5 < len(example.title) < 60 and example.text.endswith((".", ":"))
    assert 6 <= len(example.code.splitlines()) <= 32
    assert any(isinstance(node, ast.Assert) for node in ast.walk(example.tree))
    assert example.source.count(f'"{example.name}.png"') == 1


@pytest.mark.slow
@each
def test_an_example_draws_its_picture(example, tmp_path):
    if example.missing:
        pytest.skip(f"needs {', '.join(example.missing)}")
    with Image.open(example.draw(tmp_path)) as picture:
        colors = np.asarray(picture.convert("RGB").reduce(4)).reshape(-1, 3)
    assert len(np.unique(colors, axis=0)) > 20  # not a blank sheet
    assert [file.name for file in tmp_path.glob("*.png")] == [f"{example.name}.png"]
