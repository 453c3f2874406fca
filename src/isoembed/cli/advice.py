"""Python arguments in messages, rewritten as options of the command."""

import re

NUMBER = r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)"

OPTIONS = (
    (rf"(?:method=)?Alexandrov\(repair={NUMBER}\)", r"--method alexandrov --repair \1"),
    (rf"(?:method=)?Aim\(effort={NUMBER}\)", r"--effort \1"),
    (r"(?:method=)?Aim\(best_fit=True\)", "--best-fit"),
    (r'\bmethod="(\w+)"', r"--method \1"),
    (r"\bboundary='(\w+)'", r"--boundary \1"),
    (rf"\b(merge|tolerance|curvature)={NUMBER}", r"--\1 \2"),
    (r"\bmarginal=True", "--marginal"),
    (r"\bmarginal=False", "--not-marginal"),
    (r"\bgeometry=", "--geometry"),
)
"""Patterns of arguments, and the options that stand for them."""


def in_options(message: str) -> str:
    """A message of the library with options in the place of the arguments that it advises."""
    for argument, option in OPTIONS:
        message = re.sub(argument, option, message)
    return message
