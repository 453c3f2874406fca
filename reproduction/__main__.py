"""Make every figure and number of the paper again, and numbers of other papers, in one report.

    python -m reproduction --output FOLDER [--quick]

The folder gets report.html, numbers.json and figures/.  The exit status is 1 if a section could not be made
because a surface was not found; the report then says why.
"""

import argparse
import sys
from pathlib import Path

from isoembed.io import FileError
from reproduction.reproduce import STUDIES, reproduce


def main(arguments: list[str] | None = None) -> int:
    """Make the report; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m reproduction", description="Reproduce the paper.")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="made if missing")
    parser.add_argument("--quick", action="store_true", help="small meshes: one minute instead of five")
    options = parser.parse_args(arguments)

    def tell(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    try:
        outcome = reproduce(STUDIES, options.output, tell, quick=options.quick)
    except FileError as error:
        parser.error(str(error))
    print(outcome.report)
    for failure in outcome.failures:
        print(f"error: {failure}", file=sys.stderr)
    return 1 if outcome.failures else 0


if __name__ == "__main__":
    sys.exit(main())
