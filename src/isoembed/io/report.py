"""JSON output of reports."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from isoembed.io.files import Writer, write_atomically
from isoembed.io.registry import check_output
from isoembed.strict_json import strict_json

REPORT_ENDINGS = (".json",)


def report_writer(report: Mapping[str, Any]) -> Writer:
    """Writer of a report; see `write_atomically`."""
    text = strict_json(report, indent=2) + "\n"
    return lambda temporary: temporary.write_text(text, encoding="utf-8")


def write_report(path: str | os.PathLike[str], report: Mapping[str, Any]) -> None:
    """Write a report as one JSON object; nonfinite numbers become null.

    Raises
    ------
    FileError
        The ending is not ``.json`` or the file cannot be written.
    """
    check_output(path, REPORT_ENDINGS)
    write_atomically({Path(path): report_writer(report)})
