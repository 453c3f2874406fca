"""Make the pictures of docs/gallery.md again: its blocks run, and what they draw is kept in 256 colors."""

import os
import re
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

docs = Path(__file__).resolve().parent.parent
page = (docs / "gallery.md").read_text(encoding="utf-8")
blocks = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)

with TemporaryDirectory() as folder:
    os.chdir(folder)
    for block in blocks:
        exec(block, {})
    for drawn in sorted(Path(folder).glob("*.png")):
        picture = Image.open(drawn).convert("RGB").quantize(256, Image.Quantize.FASTOCTREE)
        palette, paper = picture.getpalette(), picture.getpixel((0, 0))
        palette[3 * paper : 3 * paper + 3] = 255, 255, 255  # as white as the page
        picture.putpalette(palette)
        kept = docs / "images" / "gallery" / drawn.name
        picture.save(kept, optimize=True)
        print(f"{kept.stat().st_size:9,} bytes  {kept.name}")
    os.chdir(docs)
