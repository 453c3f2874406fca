"""Build backend: that of setuptools, with a C compiler from the package index where none is installed."""

import os
import shlex
import shutil
import sys
import sysconfig
from typing import Any

from setuptools import build_meta

Settings = dict[str, Any] | None

get_requires_for_build_sdist = build_meta.get_requires_for_build_sdist
build_sdist = build_meta.build_sdist
prepare_metadata_for_build_wheel = build_meta.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = build_meta.prepare_metadata_for_build_editable


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """What the build needs: a C compiler, if there is none."""
    return build_meta.get_requires_for_build_wheel(config_settings) + _compiler()


def get_requires_for_build_editable(config_settings: Settings = None) -> list[str]:
    """As for a wheel."""
    return build_meta.get_requires_for_build_editable(config_settings) + _compiler()


def build_wheel(
    directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Compile the loops and build a wheel."""
    _choose_compiler()
    return build_meta.build_wheel(directory, config_settings, metadata_directory)


def build_editable(
    directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Compile the loops beside their sources, and build a wheel that leads to these."""
    _choose_compiler()
    return build_meta.build_editable(directory, config_settings, metadata_directory)


def _compiler() -> list[str]:
    return ["ziglang"] if _installed() is None else []


def _installed() -> str | None:
    """The command of a C compiler: that of the environment or of Python, or a common one."""
    if os.name == "nt":  # found by setuptools, in the registry
        return "cl"
    named = (os.environ.get("CC"), sysconfig.get_config_var("CC"), "cc", "gcc", "clang")
    return next((each for each in named if each and shutil.which(shlex.split(each)[0])), None)


def _choose_compiler() -> None:
    if os.name == "nt":
        return
    command = _installed() or f"{shlex.quote(sys.executable)} -m ziglang cc"
    if command != sysconfig.get_config_var("CC"):
        shared = "-bundle -undefined dynamic_lookup" if sys.platform == "darwin" else "-shared"
        os.environ["CC"] = command
        os.environ.setdefault("LDSHARED", f"{command} {shared}")
