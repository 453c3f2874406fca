"""Suggestion of a known name similar to a misspelled one ("did you mean")."""

from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str], least: float = 0.6) -> str:
    """A question to end a sentence with, or nothing if no known name is similar: 1 is equal."""
    from difflib import get_close_matches  # only on the way to an error

    words = {each.lstrip("-"): each for each in known}  # dashes would make all options similar
    near = get_close_matches(name.lstrip("-"), list(words), n=1, cutoff=least)
    return "".join(f"; did you mean {words[each]!r}?" for each in near)
