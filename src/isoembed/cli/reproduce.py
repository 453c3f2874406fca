"""``isoembed reproduce``: the paper's figures and numbers, made again, in one report."""

import argparse
import sys
from contextlib import suppress

from isoembed.cli.options import add_output_option, add_quiet_option
from isoembed.cli.screen import print_aside, print_error
from isoembed.cli.status import NOT_EMBEDDED, OK


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed reproduce``."""
    add_output_option(
        parser,
        "the folder for report.html, numbers.json and figures/; made if it is not there",
        metavar="DIR",
        required=True,
    )
    parser.add_argument("--quick", action="store_true", help="small meshes: half a minute instead of six")
    add_quiet_option(parser)


def run(options: argparse.Namespace) -> int:
    """Make the report; return the exit status."""
    from isoembed.studies import reproduce  # loads the whole library

    def tell(line: str) -> None:
        if not options.quiet and sys.stderr is not None:
            with suppress(OSError):  # nobody watches
                print(line, file=sys.stderr, flush=True)

    outcome = reproduce.reproduce(reproduce.STUDIES, options.output, tell, quick=options.quick)
    if not options.quiet:
        print_aside(str(outcome.report))
    for failure in outcome.failures:
        print_error(failure)
    return NOT_EMBEDDED if outcome.failures else OK
