"""Sphinx extension: the pages of short examples, with the pictures that they draw when the site is built.

A block ``{examples} TOPIC`` in a page holds names of examples, one a line.  It becomes thumbnails and, for
each example, its title, what its docstring says, its picture, its code and the script to download.  A block
``{thumbnails} TOPIC`` becomes the thumbnails of that page, which lead to it.
"""

import re
import shutil
import sys
import warnings
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent / "examples"))

from drawing import HERE, Example, examples

BLOCK = re.compile(r"^```\{(examples|thumbnails)\} (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
THUMBNAIL = 300  # pixels, the larger side
FOLDER = "_static/examples"  # of the pictures and the scripts


def listed(topic: str) -> list[Example]:
    """The examples of a topic, in the order of its page."""
    names = BLOCK.search((HERE / f"{topic}.md").read_text(encoding="utf-8"))
    return [Example(HERE / topic / f"{name}.py") for name in (names[3].split() if names else ())]


def thumbnail(example: Example, page: str, top: str) -> str:
    """A link to the example on a page with its picture, small, as HTML."""
    inside = f"<span>{escape(example.title)}</span>"
    if not example.missing:
        picture = f"{top}{FOLDER}/thumbnails/{example.name}.png"
        inside = f'<img src="{picture}" alt="" loading="lazy">{inside}'
    return f'<a href="{page}#example-{example.name.replace("_", "-")}">{inside}</a>'


def section(example: Example, top: str) -> str:
    """Title, text, picture, code and download of an example, in Markdown."""
    place = f"(example-{example.name.replace('_', '-')})="
    picture = f"Needs {', '.join(example.missing)}; no picture was drawn."
    if not example.missing:
        source = f"{top}{FOLDER}/{example.name}.png"
        picture = f'<img class="example" src="{source}" alt="{escape(example.title)}" loading="lazy">'
    script = f"{example.name}.py"
    download = f'<a class="download" href="{top}{FOLDER}/{script}" download>Download {script}</a>'
    code = f"```python\n{example.code}```\n\n{download}\n"
    return f"{place}\n## {example.title}\n\n{example.text}\n\n{picture}\n\n{code}"


def shown(match: re.Match[str], top: str) -> str:
    """What comes in place of a block, on a page from which it is this way up to the first folder."""
    kind, topic, _ = match.groups()
    page = f"examples/{topic}.html" if kind == "thumbnails" else ""
    row = "".join(thumbnail(example, page, top) for example in listed(topic))
    sections = "\n".join(section(example, top) for example in listed(topic)) if kind == "examples" else ""
    return f'<div class="thumbnails">{row}</div>\n\n{sections}'


def fill(app: Sphinx, page: str, content: list[str]) -> None:
    """Put examples where they belong when a page is read."""
    content[0] = BLOCK.sub(lambda match: shown(match, "../" * page.count("/")), content[0])


def draw(app: Sphinx) -> None:
    """Put all scripts, their pictures and thumbnails into a folder of static files."""
    kept = TemporaryDirectory()
    app.connect("build-finished", lambda app, exception: kept.cleanup())
    folder = Path(kept.name) / "examples"
    (folder / "thumbnails").mkdir(parents=True)
    for example in examples():
        shutil.copy(example.path, folder)
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
