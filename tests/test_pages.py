"""The code of the README and of the pages of docs/ runs, and draws the pictures that are kept."""

from pathlib import Path

import pytest
from PIL import Image

from page_blocks import tasks
from pages import ALIKE, DOCS, PAGES, PICTURE, difference
from places import ROOT

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for task in tasks(page):
        task()
    for name in PICTURE.findall(page.read_text(encoding="utf-8")):
        with Image.open(DOCS / name) as kept, Image.open(tmp_path / Path(name).name) as drawn:
            found = difference(kept, drawn)
        assert found < ALIKE, f"{page.name}: the block draws another {name} ({found:.3f}); make it again"
