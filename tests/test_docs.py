"""The README and the pages of docs/ do what they say: Python and commands run, links lead on.

The blocks of a page run in order in one temporary folder, each Python block in a namespace of its own.
"""

import os
import re
import shlex
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")


def blocks(page):
    """Yield (language, first line, text) of the fenced blocks."""
    text = page.read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        yield match[1], text.count("\n", 0, match.start(2)) + 1, match[2]


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


def test_there_is_code_to_run():
    languages = [language for page in PAGES for language, _, _ in blocks(page)]
    assert languages.count("python") >= 4
    assert languages.count("console") >= 3


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_links_lead_to_files(page):
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if not target.startswith(("https:", "mailto:")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"
