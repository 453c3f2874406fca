"""The code of the README and of the pages of docs/ runs, and draws the pictures that are kept.

The blocks of a page run in order in one temporary folder, each Python block in a namespace of its own.
"""

import os
import re
import shlex
import subprocess
import sysconfig
from pathlib import Path

import pytest
from PIL import Image

from pages import ALIKE, DOCS, PAGES, PICTURE, blocks, difference
from places import ROOT

pytestmark = pytest.mark.slow


def run(command, folder):
    scripts = sysconfig.get_path("scripts")
    environment = os.environ | {"PATH": scripts + os.pathsep + os.environ["PATH"]}
    return subprocess.run(shlex.split(command), cwd=folder, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for language, line, text in blocks(page):
        if language == "python":
            code = compile("\n" * (line - 1) + text, str(page), "exec")
            exec(code, {"__name__": "__main__"})
        elif language == "console":
            for entry in re.findall(r"^\$ (isoembed .*)$", text.replace("\\\n", " "), re.MULTILINE):
                done = run(entry, tmp_path)
                assert done.returncode == 0, f"{page.name}, line {line}: {entry}\n{done.stderr}"
                assert "Traceback" not in done.stderr
    for name in PICTURE.findall(page.read_text(encoding="utf-8")):
        with Image.open(DOCS / name) as kept, Image.open(tmp_path / Path(name).name) as drawn:
            found = difference(kept, drawn)
        assert found < ALIKE, f"{page.name}: the block draws another {name} ({found:.3f}); make it again"
