"""Registry of embedding methods by name, with those of installed packages.

Another package registers a method by an entry point of the group ``isoembed.methods``.
"""

from importlib.metadata import EntryPoint, entry_points
from inspect import isabstract

from isoembed.errors import InvalidParameter
from isoembed.method import Method
from isoembed.similar_names import did_you_mean

METHODS = {
    "aim": "isoembed.aim.adaptive:Aim",
    "paper": "isoembed.aim.paper:Paper",
    "alexandrov": "isoembed.alexandrov.method:Alexandrov",
    "sheet": "isoembed.sheets.method:Sheet",
}
"""Entry points of the methods of this package, which are imported on first use."""

GROUP = "isoembed.methods"
"""The entry points under which other packages bring theirs."""


def as_method(method: str | Method) -> Method:
    """The method of this name with its default parameters, or the given method itself.

    Raises
    ------
    InvalidParameter
        There is no such method.
    """
    if isinstance(method, str):
        kind = method_class(method)
        try:
            return kind()
        except TypeError as error:  # a parameter without a default
            raise InvalidParameter(f"the method {method!r} needs parameters: {error}") from None
    if isinstance(method, type):
        raise InvalidParameter(f"the method is the class {method.__name__}: make one, {method.__name__}()")
    if not isinstance(method, Method):
        raise InvalidParameter(f"the method is a {type(method).__name__}: derive it from isoembed.Method")
    if not isinstance(getattr(method, "name", None), str):
        raise InvalidParameter(f"the class {type(method).__name__} has no name: define name = '...' in it")
    return method


def method_class(name: str) -> type[Method]:
    """The class of the method of this name.

    Raises
    ------
    InvalidParameter
        There is none, or the package that brings it has an invalid entry point.
    """
    if name in METHODS:
        found = EntryPoint(name, METHODS[name], GROUP)
    else:
        brought = tuple(entry_points(group=GROUP, name=name))
        if not brought:
            names = method_names()
            near = did_you_mean(name, names)
            raise InvalidParameter(f"there is no method {name!r}; there are {', '.join(names)}{near}")
        found = brought[0]
    try:
        kind = found.load()
    except Exception as error:  # whatever a module of others raises
        raise InvalidParameter(
            f"the method {name!r} cannot be loaded from {found.value}: {type(error).__name__}: {error}"
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Method)):
        raise InvalidParameter(
            f"the method {name!r} is {found.value}, which is not derived from isoembed.Method"
        )
    if isabstract(kind) or not isinstance(getattr(kind, "name", None), str):
        raise InvalidParameter(f"the method {name!r} is {found.value}, which lacks a name or the method run")
    return kind


def method_names() -> tuple[str, ...]:
    """The names that ``method=`` may be: of this package's methods, then of those that others bring."""
    return tuple(dict.fromkeys([*METHODS, *sorted(entry_points(group=GROUP).names)]))
