"""Sphinx extension: the page of short examples, with the pictures that they draw when the site is built.

A block ``{examples} TOPIC`` in a page holds names of examples, one a line.  In its place come thumbnails, and
for each example its title, what its docstring says, its picture and its code.
"""

import re
import sys
import warnings
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent / "examples"))

from drawing import HERE, Example, examples

BLOCK = re.compile(r"^```\{examples\} (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
THUMBNAIL = 300  # pixels, the larger side
FOLDER = "examples"  # in the folder of static files, of the pictures


def thumbnail(example: Example) -> str:
    """A link to the example with its picture, small, as HTML."""
    inside = f"<span>{escape(example.title)}</span>"
    if not example.missing:
        picture = f"_static/{FOLDER}/thumbnails/{example.name}.png"
        inside = f'<img src="{picture}" alt="" loading="lazy">{inside}'
    return f'<a href="#example-{example.name.replace("_", "-")}">{inside}</a>'


def section(example: Example) -> str:
    """Title, text, picture and code of an example, in Markdown."""
    place = f"(example-{example.name.replace('_', '-')})="
    picture = f"Needs {', '.join(example.missing)}; no picture was drawn."
    if not example.missing:
        source = f"_static/{FOLDER}/{example.name}.png"
        picture = f'<img class="example" src="{source}" alt="{escape(example.title)}" loading="lazy">'
    return f"{place}\n### {example.title}\n\n{example.text}\n\n{picture}\n\n```python\n{example.code}```\n"


def shown(match: re.Match[str]) -> str:
    """What comes in place of a block."""
    listed = [Example(HERE / match[1] / f"{name}.py") for name in match[2].split()]
    row = "".join(thumbnail(example) for example in listed)
    sections = "\n".join(section(example) for example in listed)
    return f'<div class="thumbnails">{row}</div>\n\n{sections}'


def fill(app: Sphinx, page: str, content: list[str]) -> None:
    """Put examples where they belong when a page is read."""
    content[0] = BLOCK.sub(shown, content[0])


def draw(app: Sphinx) -> None:
    """Draw all pictures and thumbnails into a folder of static files."""
    kept = TemporaryDirectory()
    app.connect("build-finished", lambda app, exception: kept.cleanup())
    folder = Path(kept.name) / FOLDER
    (folder / "thumbnails").mkdir(parents=True)
    for example in examples():
        if example.missing:
            continue
        with TemporaryDirectory() as away, warnings.catch_warnings(action="error"):
            picture = Image.open(example.draw(Path(away))).convert("RGB")
        picture.quantize(256, Image.Quantize.FASTOCTREE).save(folder / f"{example.name}.png", optimize=True)
        picture.thumbnail((THUMBNAIL, THUMBNAIL))
        picture.save(folder / "thumbnails" / f"{example.name}.png", optimize=True)
    app.config.html_static_path.append(str(Path(kept.name)))


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", draw)
    app.connect("source-read", fill)
    return {"parallel_read_safe": True}
