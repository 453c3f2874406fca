"""The short examples: scripts in the folder of a topic. Each draws one picture with its own name.

``python docs/examples/drawing.py FOLDER`` draws all of them there.
"""

import ast
import contextlib
import io
import runpy
import sys
import time
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Example:
    """A script ``<topic>/<name>.py`` that draws ``<name>.png`` in the current folder.

    Its docstring is a title that ends with a period and, after an empty line, what is to be said.
    """

    path: Path

    @property
    def topic(self) -> str:
        """Name of its folder."""
        return self.path.parent.name

    @property
    def name(self) -> str:
        """What the script and its picture are called."""
        return self.path.stem

    @property
    def source(self) -> str:
        """The whole script."""
        return self.path.read_text(encoding="utf-8")

    @property
    def tree(self) -> ast.Module:
        """The script, parsed."""
        return ast.parse(self.source)

    @property
    def title(self) -> str:
        """First line of its docstring."""
        return (ast.get_docstring(self.tree) or "").partition("\n")[0].removesuffix(".")

    @property
    def text(self) -> str:
        """The rest of its docstring, in Markdown."""
        return (ast.get_docstring(self.tree) or "").partition("\n")[2].strip()

    @property
    def code(self) -> str:
        """The script without its docstring."""
        return "\n".join(self.source.splitlines()[self.tree.body[0].end_lineno :]).strip() + "\n"

    @property
    def missing(self) -> list[str]:
        """Packages that it imports and that are not installed."""
        imported = set()
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add((node.module or "").partition(".")[0])
        return sorted(name for name in imported if find_spec(name) is None)

    def draw(self, folder: Path) -> Path:
        """Run it in a folder, silently; the picture that it draws."""
        with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()):
            runpy.run_path(str(self.path), run_name="__main__")
        return folder / f"{self.name}.png"


def examples() -> list[Example]:
    """All of them, by topic and name."""
    return [Example(path) for path in sorted(HERE.glob("*/*.py"))]


if __name__ == "__main__":
    (target,) = sys.argv[1:]
    for example in examples():
        if example.missing:
            print(f"{'':8}  {example.topic}/{example.name} needs {', '.join(example.missing)}")
            continue
        start = time.process_time()
        example.draw(Path(target).resolve())
        print(f"{time.process_time() - start:6.2f} s  {example.topic}/{example.name}", flush=True)
