"""Suggestion of a known name similar to a misspelled one ("did you mean")."""

from collections.abc import Iterable

FEWEST = 4  # letters of a beginning
BEGINNING = 0.8  # as of `did_you_mean`


def did_you_mean(name: str, names: Iterable[str], cutoff: float = 0.6) -> str:
    """A question to end a sentence with, or nothing if no known name is similar: 1 is equal."""
    from difflib import get_close_matches  # only on the way to an error

    words = {each.lstrip("-").lower(): each for each in names}  # dashes would make all options similar
    typed = name.lstrip("-").lower()
    near = get_close_matches(typed, list(words), n=1, cutoff=cutoff)
    if not near and cutoff < BEGINNING and len(typed) >= FEWEST:  # the beginning of a longer one
        begins = {word[: len(typed) + 1]: word for word in words}
        near = [begins[word] for word in get_close_matches(typed, list(begins), n=1, cutoff=BEGINNING)]
    return "".join(f"; did you mean {words[each]!r}?" for each in near)
