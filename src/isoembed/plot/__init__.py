"""Pictures, films and browser pages of surfaces.

Pictures and films require matplotlib: ``pip install matplotlib``.

The names are imported on first use.
"""

import warnings
from typing import Any

import lazy_loader

_attached, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name not in ("SHEET_ENDINGS", "sheets_writer", "write_sheets"):
        return _attached(name)
    warnings.warn(
        f"isoembed.plot.{name} is isoembed.papercraft.{name} now; the old name goes with version 0.5",
        DeprecationWarning,
        stacklevel=2,
    )
    from isoembed import papercraft

    return getattr(papercraft, name)
