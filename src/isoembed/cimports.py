"""Import hook for ``cython.cimports.isoembed`` in interpreted runs: the Python modules of the same names."""

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

_CIMPORTS = "cython.cimports."


class _PythonModules:
    """Finder and loader of ``cython.cimports.isoembed``."""

    @classmethod
    def find_spec(cls, name: str, path: object, target: object = None) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder.find_spec`."""
        if not name.startswith(f"{_CIMPORTS}isoembed."):
            return None
        return ModuleSpec(name, cls)  # type: ignore[arg-type]  # has a loader's methods

    @staticmethod
    def create_module(spec: ModuleSpec) -> None:
        """See `importlib.abc.Loader.create_module`."""

    @staticmethod
    def exec_module(module: ModuleType) -> None:
        """Replace the new, empty module by the Python module."""
        name = module.__name__
        sys.modules[name] = import_module(name.removeprefix(_CIMPORTS))


sys.modules[f"{_CIMPORTS}isoembed"] = sys.modules["isoembed"]
sys.meta_path.insert(0, _PythonModules)  # before the finder of files, which would load them twice
