"""Pictures, films and browser pages of surfaces; printable nets.

Still ones, films and nets as PDF need matplotlib: ``pip install 'isoembed[plot]'``.

The names are imported on first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
