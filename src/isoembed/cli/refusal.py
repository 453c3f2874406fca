"""What a user can cause: exit status 2 and one line."""

from __future__ import annotations

from isoembed.cli.screen import OutputError
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.io import FileError


class UsageError(ValueError):
    """A command line that is well formed but makes no sense."""


USER_ERRORS = (UsageError, FileError, InvalidMetric, InvalidParameter, OutputError)
