"""What is public: names with their kinds and parameters, one a line.

Public is what ``__all__`` of a package lists and what the pages of docs/api document.

    python tests/support/public_api.py

writes tests/public_api.txt.
"""

import enum
import importlib
import inspect
import pkgutil
import re
from functools import cached_property

import isoembed
from places import ROOT

KEPT = ROOT / "tests" / "public_api.txt"
DIRECTIVE = re.compile(r"^\.\. auto\w+:: (isoembed\S*)$", re.MULTILINE)
INTERNAL = {"isoembed.cli"}
PLAIN = (type(None), bool, int, float, str, tuple)


def names():
    """The names that are public."""
    found = {
        name
        for page in (ROOT / "docs" / "api").glob("*.md")
        for name in DIRECTIVE.findall(page.read_text(encoding="utf-8"))
    }
    packages = [room.name for room in pkgutil.walk_packages(isoembed.__path__, "isoembed.") if room.ispkg]
    for package in {"isoembed", *packages} - INTERNAL:
        found |= {f"{package}.{name}" for name in getattr(importlib.import_module(package), "__all__", ())}
    return sorted(found)


def resolved(name):
    """The object of a dotted name."""
    parts = name.split(".")
    for n in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:n]))
        except ModuleNotFoundError:
            continue
        for part in parts[n:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


def parameters(function):
    """The parameters of a function with their defaults, without types."""
    signature = inspect.signature(function)
    shown = []
    for parameter in signature.parameters.values():
        if isinstance(parameter.default, PLAIN):
            default = parameter.default
        else:
            default = parameter.default if parameter.default is parameter.empty else ...
        shown.append(parameter.replace(annotation=parameter.empty, default=default))
    text = signature.replace(parameters=shown, return_annotation=signature.empty)
    return str(text).replace("Ellipsis", "...")


def is_ours(cls):
    """Whether a class was written here."""
    return cls.__module__.partition(".")[0] == "isoembed"


def members(cls):
    """Yield the lines of a class's public members, inherited ones of ours among them."""
    seen = {}
    for owner in filter(is_ours, cls.__mro__):
        for name, value in vars(owner).items():
            if not name.startswith("_"):
                seen.setdefault(name, value)
    for name, value in sorted(seen.items()):
        if isinstance(value, classmethod | staticmethod):
            yield f".{name}{parameters(getattr(cls, name))}"
        elif inspect.isfunction(value):
            yield f".{name}{parameters(value)}"
        elif isinstance(value, property | cached_property):
            yield f".{name}"


def lines():
    """The lines that describe what is public."""
    described = {}
    for name in names():
        value = resolved(name)
        if inspect.ismodule(value):
            continue
        if inspect.isclass(value) and is_ours(value):
            if (other := described.setdefault(value, name)) != name:
                yield f"{name} is {other}"
                continue
            made_here = any({"__init__", "__new__"} & vars(c).keys() for c in filter(is_ours, value.__mro__))
            plain = made_here and not issubclass(value, enum.Enum)
            yield f"class {name}{parameters(value) if plain else ''}"
            yield from (f"{name}{member}" for member in members(value))
        elif callable(value) and not inspect.isclass(value):
            yield f"{name}{parameters(value)}"
        else:
            yield name


def changes(kept, now):
    """Sentences that say what became of each public name."""
    before, after = (
        {re.match(r"(?:class )?([\w.]+)", line)[1]: line for line in part} for part in (kept, now)
    )
    yield from (f"{name} is gone" for name in sorted(before.keys() - after.keys()))
    yield from (f"{name} is new" for name in sorted(after.keys() - before.keys()))
    for name in sorted(before.keys() & after.keys()):
        if before[name] != after[name]:
            yield f"{before[name]} has become {after[name]}"


if __name__ == "__main__":
    KEPT.write_text("".join(f"{line}\n" for line in lines()), encoding="utf-8")
