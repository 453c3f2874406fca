"""Shell completion for bash, zsh and fish, by shtab."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from isoembed.cli.console import UsageError

SHELLS = ("bash", "zsh", "fish")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Completion script of a shell for a parser and its subcommands.

    Raises
    ------
    UsageError
        shtab is not installed.
    """
    try:
        import shtab
    except ImportError:
        raise UsageError("completion needs shtab: pip install shtab") from None
    for action in _actions(parser):
        if _is_file(action):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    text: str = shtab.complete(parser, shell)
    return text


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Actions of a parser and of its subcommands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        else:
            yield action


def _is_file(action: argparse.Action) -> bool:
    if action.choices is not None or action.nargs == 0:
        return False
    return action.type is Path or not action.option_strings
