"""Help of the command and its subcommands: options in groups, examples, exit statuses.

For a subcommand with many options, ``--help`` lists the common ones and ``--help-all`` all of them.
"""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from isoembed.cli.console import print_out

GROUPS = {
    "input": (
        *("merge", "lengths", "length_error", "mean_curvature", "momentum", "normal_momentum", "time"),
        *("space", "start", "boundary"),
    ),
    "spacetime": (
        *("spacetime", "mass", "spin", "charge", "cosmological_constant", "surface", "slice"),
        "disc",
        *("sphere", "geometry", "center", "velocity", "masses", "positions", "velocities"),
        *("marginal", "not_marginal"),
    ),
    "search": (
        *("method", "which", "best_fit", "repair", "effort", "tolerance", "parameter", "find", "guess"),
        *("vertices", "size", "grading", "zone", "distance", "motions", "surfaces"),
        *("objective", "cut_edges", "keep_edges"),
    ),
    "struts": ("hub_radius", "stock"),
    "report": ("axis", "wang_yau", "multipoles", "stability", "bound"),
    "output": (
        *("output", "report", "metric", "picture", "color", "html", "animate", "film", "band", "paper"),
        *("scale", "solid_size", "numbers", "keep", "json", "verbose", "quiet"),
    ),
    "material": (
        *("joints", "allowance", "thickness", "kerf", "bends", "spacing", "hole", "dash", "gap"),
        *("sheet_surface", "k_factor", "radius"),
    ),
    "runs": (*("checkpoint", "resume", "jobs", "scheduler", "shard", "chunk", "retry", "force"),),
}
"""Titles of option groups and the options in each; remaining options are listed last, as ``options``."""

COMMAND_GROUPS: Mapping[str, Mapping[str, str]] = {
    "surfaces": {
        "embed": "find the surface that has the given edge lengths",
        "inspect": "describe the metric in a file and the consequences for its embedding",
        "surface": "write the metric of a closed-form surface (ellipsoid, drum, Kerr horizon, ...)",
        "view": "show a surface in the browser or as a picture, or several as a film",
    },
    "proofs and errors": {
        "certify": "prove that exactly one exact surface is near the one in a file",
        "compare": "compare two surfaces with the same lengths, with proven errors",
        "deviation": "estimate the deviations of a surface due to errors of its lengths",
        "realizations": "search for surfaces with the same lengths near the one in a file",
    },
    "paper": {
        "glue": "build a solid from a paper net: polygons whose sides are glued together",
        "nets": "solve classic nets: the Latin cross, tetramonohedra, pita forms, D-forms, ...",
        "struts": "list the struts and hubs of a dome or a frame: types, lengths, angles, cuts",
        "unfold": "make a paper net of a solid, to print, cut, fold and glue",
    },
    "relativity": {
        "energy": "compute quasi-local energies of a surface in spacetime (Hawking, Liu-Yau, ...)",
        "horizon": "embed horizons, from files or found in a slice, and compute their energies",
        "series": "embed the horizons of a whole simulation, each in its own slice: tables, plots, films",
        "triangulate": "cut a smooth 2-metric into triangles with geodesic lengths",
    },
}
"""Subcommands and their purposes, in groups."""

COMMANDS = {name: purpose for group in COMMAND_GROUPS.values() for name, purpose in group.items()}

FIRST_STEPS = """\
Five things to try:
  isoembed surface ellipsoid --axes 3 2 1 --vertices 100 -o metric.npz
  isoembed embed metric.npz -o surface.ply
  isoembed inspect surface.ply
  isoembed unfold surface.ply -o net.svg
  isoembed view surface.ply -o surface.html"""

EXIT_STATUS = """\
Exit status: 0 done; 2 wrong input or command line; 3 no embedding within the
tolerance, no horizon or no proof; 130 interrupted by Ctrl-C, 143 by SIGTERM."""

Section = tuple[str, list[argparse.Action]]


class ShowAll(argparse.Action):
    """Option ``--help-all``: print the help with all options."""

    def __init__(self, option_strings: Any, dest: str, **options: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Print the help and exit."""
        print_out(text(parser, (), getattr(parser, "examples", ())))
        parser.exit()


def text(parser: argparse.ArgumentParser, usual: Collection[str], examples: Collection[str] = ()) -> str:
    """Help text of a parser.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    usual : collection of str
        Names of the options to list; all if empty.
    examples : collection of str
        Example command lines.
    """
    formatter = parser._get_formatter()
    formatter.add_usage(_usage(parser), (), ())
    formatter.add_text(parser.description)
    hidden = 0
    for title, actions in _sections(parser):
        listed = [action for action in actions if not usual or not _is_option(action) or action.dest in usual]
        hidden += len(actions) - len(listed)
        formatter.start_section(title)
        formatter.add_arguments(listed)
        formatter.end_section()
    parts = [formatter.format_help().rstrip("\n")]
    if hidden:
        parts.append(f"{hidden} more options: {parser.prog} --help-all")
    if examples:
        parts.append("\n  ".join(["examples:", *examples]))
    return "\n\n".join([*parts, EXIT_STATUS])


def _usage(parser: argparse.ArgumentParser) -> str:
    """Usage line with required options only."""
    formatter, words = parser._get_formatter(), [parser.prog]
    for action in parser._actions:
        if action.option_strings and action.required:
            words += [action.option_strings[0], formatter._format_args(action, action.dest.upper())]
    words.append("[options]")
    for action in parser._get_positional_actions():
        words.append(formatter._format_args(action, action.dest))
    return " ".join(words)


def _sections(parser: argparse.ArgumentParser) -> Iterator[Section]:
    """Arguments, commands in groups, and options in groups."""
    positional = parser._get_positional_actions()
    chosen = [action for action in positional if isinstance(action, argparse._SubParsersAction)]
    yield "arguments", [action for action in positional if action not in chosen]
    for action in chosen:
        choices = {choice.dest: choice for choice in action._get_subactions()}
        if choices.keys() == COMMANDS.keys():
            for title, group in COMMAND_GROUPS.items():
                yield title, [choices[name] for name in group]
        else:
            yield "surfaces", list(choices.values())
    left = [action for action in parser._get_optional_actions() if action.help is not argparse.SUPPRESS]
    for title, names in GROUPS.items():
        yield title, [action for action in left if action.dest in names]
        left = [action for action in left if action.dest not in names]
    yield "options", left


def _is_option(action: argparse.Action) -> bool:
    return bool(action.option_strings) and action.dest not in ("help", "help_all")
