"""The fenced blocks of a page, and how they are run; needs nothing but Python.

A page's blocks run in order in one folder, each Python block in a namespace of its own.

    python tests/support/page_blocks.py PAGE...

runs the pages with what is installed.  A block that needs an extra has to say which one to install.
"""

import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from contextlib import chdir, redirect_stdout
from pathlib import Path

FENCE = re.compile(r"^```([^`\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ (isoembed .*)$", re.MULTILINE)
EXTRA = re.compile(r"pip install [\w'\[\]-]+(?: [\w-]+)*")


NUMBER = r"-?\d+(?:\.\d+)?"
SAID = re.compile(rf"\)  # ({NUMBER})(?![\w./-])")


class CommandError(Exception):
    """A command of a page failed."""


class Printed:
    """The ``print`` of a page: the number in a comment beside it is the first that it prints, rounded."""

    def __init__(self, page):
        self.page, self.lines = page, page.read_text(encoding="utf-8").splitlines()

    def __call__(self, *values, **options):
        """Print what the page says."""
        frame = sys._getframe(1)
        line = self.lines[frame.f_lineno - 1] if frame.f_code.co_filename == str(self.page) else ""
        if said := SAID.search(line):
            found = float(re.search(NUMBER, " ".join(map(str, values)))[0])
            rounding = 0.51 * 10.0 ** -len(said[1].partition(".")[2])
            assert abs(found - float(said[1])) <= rounding, f"{self.page.name}: {line} prints {found}"
        print(*values, **options)


def blocks(page):
    """Yield (language, first line, text) of the fenced blocks."""
    text = page.read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        yield match[1], text.count("\n", 0, match.start(2)) + 1, match[2]


def tasks(page):
    """Yield what does the work of a block, for each block that is run: Python code, or commands."""
    for language, line, text in blocks(page):
        if language == "python":
            code = compile("\n" * (line - 1) + text, str(page), "exec")
            yield lambda code=code: exec(code, {"__name__": "__main__", "print": Printed(page)})
        elif language == "console":
            entries = COMMAND.findall(text.replace("\\\n", " "))
            yield lambda entries=entries, line=line: call(entries, f"{page.name}, line {line}")


def call(entries, where):
    """Call commands in this folder, with the scripts of this Python first."""
    environment = os.environ | {"PATH": sysconfig.get_path("scripts") + os.pathsep + os.environ["PATH"]}
    for entry in entries:
        done = subprocess.run(shlex.split(entry), env=environment, capture_output=True, text=True)
        if done.returncode or "Traceback" in done.stderr:
            raise CommandError(f"{where}: {entry}\n{done.stderr}")


def main(pages):
    """Run pages, each in an empty folder; count the blocks that ran and those that asked for an extra."""
    for page in map(Path, pages):
        page, asked, ran = page.resolve(), [], 0
        with tempfile.TemporaryDirectory() as folder, chdir(folder):
            for task in tasks(page):
                try:
                    with redirect_stdout(None):
                        task()
                    ran += 1
                except Exception as error:
                    if (extra := EXTRA.search(str(error))) is None:
                        raise
                    asked.append(extra[0])
        needs = "".join(f"; {asked.count(extra)} said: {extra}" for extra in sorted(set(asked)))
        print(f"{page.name}: {ran} blocks ran{needs}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
