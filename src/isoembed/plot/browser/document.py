"""Self-contained HTML document of a browser page."""

import base64
import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Any

from isoembed.io.files import Writer
from isoembed.plot.browser.packing import Packed
from isoembed.strict_json import strict_json
from isoembed.version import __version__


@dataclass(frozen=True, eq=False)
class Document:
    """A browser page.

    Attributes
    ----------
    title, caption : str
        Plain text.
    report : str
        HTML beside the surface.
    download : object
        Object for download as JSON.
    data : mapping
        Input of the script; see ``page-lint/page.d.ts``.
    arrays : Packed
        Arrays referenced by the data.
    """

    title: str
    caption: str
    report: str
    download: Any
    data: Mapping[str, Any]
    arrays: Packed

    @property
    def writer(self) -> Writer:
        """Writer of the page; see `isoembed.io.write_atomically`."""
        text = self.text
        # File names may contain any bytes.
        return lambda temporary: temporary.write_text(text, encoding="utf-8", errors="replace")

    @property
    def text(self) -> str:
        """HTML text of the page."""
        assets = files("isoembed.plot") / "browser"
        style, script, page = ((assets / f"page.{kind}").read_text("utf-8") for kind in ("css", "js", "html"))
        parts = {
            "title": escape(self.title),
            "caption": escape(self.caption),
            "version": __version__,
            "style": style,
            "style hash": _hash(style),
            "script": script,
            "script hash": _hash(script),
            "report": self.report,
            "json": base64.b64encode(strict_json(self.download, indent=2).encode()).decode("ascii"),
            "data": strict_json(self.data).replace("<", r"\u003c"),  # prevents closing tags in the data
            "arrays": self.arrays.text,
        }
        return re.sub(r"\{\{([a-z ]+)\}\}", lambda match: parts[match[1]], page)


def _hash(text: str) -> str:
    """Hash of a style or script for the page's content security policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
