"""Command-line parameters ``NAME=VALUE`` for the fields of a frozen dataclass."""

import types
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from isoembed import methods
from isoembed.cli.console import UsageError
from isoembed.method import Method

TRUTH = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


def configured(method: str, assignments: Sequence[str], **given: Any) -> Method:
    """Create the named method with given parameters.

    Parameters
    ----------
    method : str
    assignments : sequence of str
        Parameters ``NAME=VALUE``, named after fields of the method's configuration.
    **given
        Fields of other types, used unchanged.

    Raises
    ------
    UsageError
        A parameter is unknown to the method, or its value is invalid.
    """
    configuration = methods.method_class(method)
    known, needed = parameters(configuration), parameters(configuration, needed=True)
    types_ = get_type_hints(configuration)
    values = dict(given)
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals:
            raise UsageError(f"--parameter {assignment} is not of the form NAME=VALUE")
        if name not in known:
            raise UsageError(
                f"the method {method!r} has no parameter {name!r}; it has {', '.join(known) or 'none'}"
            )
        try:
            values[name] = parsed(text, types_[name])
        except ValueError as error:
            raise UsageError(f"--parameter {assignment}: {error}") from None
    missing = [name for name in needed if name not in values]
    if missing:
        raise UsageError(f"the method {method!r} needs --parameter {missing[0]}=VALUE")
    try:
        return configuration(**values)
    except ValueError as error:
        raise UsageError(f"method {method!r}: {error}") from None


def parameters(configuration: type[Method], *, needed: bool = False) -> list[str]:
    """Names of a method's parameters, the fields of its dataclass; optionally only those without default."""
    every: list[Field] = [f for f in fields(configuration) if f.init] if is_dataclass(configuration) else []
    return [f.name for f in every if not needed or (f.default is MISSING and f.default_factory is MISSING)]


def parsed(text: str, type_: Any) -> Any:
    """Parse a value of a field's type: bool, int, float, str, a Literal of strings, or a union of these.

    Raises
    ------
    ValueError
        The value is invalid; the message is meant for the user.
    """
    origin = get_origin(type_)
    if origin is Literal:
        if text not in get_args(type_):
            raise ValueError(f"{text!r} is not one of {', '.join(get_args(type_))}")
        return text
    if origin in (Union, types.UnionType):
        if text.lower() == "none" and type(None) in get_args(type_):
            return None
        *others, last = (option for option in get_args(type_) if option is not type(None))
        for option in others:
            with suppress(ValueError):
                return parsed(text, option)
        return parsed(text, last)
    if type_ is bool:
        if text.lower() not in TRUTH:
            raise ValueError(f"{text!r} is not true or false")
        return TRUTH[text.lower()]
    if type_ is str:
        return text
    if type_ not in (int, float):
        raise ValueError(f"a parameter of type {getattr(type_, '__name__', type_)} can only be set in Python")
    try:
        return type_(text)
    except ValueError:
        raise ValueError(f"{text!r} is not {'a whole number' if type_ is int else 'a number'}") from None
