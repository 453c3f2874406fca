"""Display of surfaces in notebooks: an interactive page, or a picture of a large surface."""

from __future__ import annotations

import base64
import io
from html import escape

from isoembed.embedding.embedding import Embedding
from isoembed.io.files import FileError
from isoembed.plot.page import page_html
from isoembed.plot.picture import figure

PAGE_VERTICES = 5000  # above, the report of a page takes seconds, and a picture is shown


def notebook_html(embedding: Embedding) -> str | None:
    """HTML of a surface in a notebook.

    Returns
    -------
    str or None
        A frame with the self-contained page of `isoembed.plot.write_page`, or a picture if there are more
        than 5,000 vertices.  None without matplotlib, so that the notebook shows the text.
    """
    if embedding.triangulation.n_vertices <= PAGE_VERTICES:
        page = escape(page_html(embedding, title="Surface"))
        return (
            f'<iframe srcdoc="{page}" title="{escape(repr(embedding))}" '
            'sandbox="allow-scripts allow-downloads" loading="lazy" '
            f'style="width: 100%; height: 560px; border: 0"></iframe>'
        )
    try:
        drawn = figure(embedding)
    except FileError:
        return None
    picture = io.BytesIO()
    drawn.savefig(picture, format="png", dpi=100)
    data = base64.b64encode(picture.getvalue()).decode("ascii")
    return f'<img src="data:image/png;base64,{data}" alt="{escape(repr(embedding))}">'
