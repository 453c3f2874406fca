"""``isoembed inspect``: what kind of metric a file holds, and what that means for its embedding."""

from __future__ import annotations

import argparse
import json

from isoembed.cli.inspection import Inspection, inspect
from isoembed.cli.screen import print_out
from isoembed.cli.status import OK
from isoembed.io import read_metric


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed inspect``."""
    parser.add_argument(
        "input",
        metavar="INPUT",
        help="a metric (.npz .json), a mesh (.obj .ply .stl .off .vtk .vtu), or - for JSON on standard input",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(options: argparse.Namespace) -> int:
    """Inspect the input; return the exit status."""
    metric = read_metric(options.input)
    found = inspect(metric)
    print_out(
        json.dumps(found.as_json(), indent=2, allow_nan=False)
        if options.json
        else _text(options.input, found)
    )
    return OK


def _text(name: str, found: Inspection) -> str:
    lines = [f"{name}: a polyhedral metric on the sphere", ""]
    width = max(len(measure.name) for measure in found.measures)
    lines += [f"{measure.name:{width}}  {measure.text}" for measure in found.measures]
    if found.warnings:
        lines += ["", *(f"warning: {warning.text}" for warning in found.warnings)]
    else:
        lines += ["", "Nothing stands against an embedding."]
    return "\n".join(lines)
