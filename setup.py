"""The modules that are compiled: those whose first line has directives of Cython.

They are Python, and run as such where they are not compiled and Cython is installed.
"""

import hashlib
import os
import shutil
import sys
import sysconfig
import threading
from pathlib import Path

import Cython
from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCES = Path("src")
BUILD = Path("build")
FREE_THREADED = bool(sysconfig.get_config_var("Py_GIL_DISABLED"))  # has no stable binary interface
STABLE = 0x030B0000  # Python 3.11, the first whose limited interface has buffers

# Sums and products are rounded as they are written, on all machines.
FLAGS = ["/O2", "/fp:precise"] if os.name == "nt" else ["-O3", "-ffp-contract=off", "-g0"]
# But for sums of many products, which take vector instructions in any order only.
ANY_ORDER = [] if os.name == "nt" else ["-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math"]
SUMS = {"isoembed.linalg.fronts", "isoembed.surface.interpolation_loops"}
MACROS = [("CYTHON_CCOMPLEX", "0")]  # products of complex numbers without a search for infinities


def compiled_modules() -> list[Extension]:
    """Modules to compile."""
    macros = MACROS if FREE_THREADED else [*MACROS, ("Py_LIMITED_API", hex(STABLE))]
    sources = [path for path in sorted(SOURCES.rglob("*.py")) if path.read_bytes().startswith(b"# cython:")]
    names = [".".join(path.relative_to(SOURCES).with_suffix("").parts) for path in sources]
    return [
        Extension(
            name,
            [path.as_posix()],
            define_macros=macros,
            extra_compile_args=FLAGS + ANY_ORDER if name in SUMS else FLAGS,
            py_limited_api=not FREE_THREADED,
        )
        for name, path in zip(names, sources, strict=True)
    ]


class Compile(build_ext):
    """Translate to C and compile what was not compiled before: what was is kept in ``build/``."""

    _cython = threading.Lock()  # has global state

    def finalize_options(self) -> None:
        """Compile as many modules at once as there are cores."""
        super().finalize_options()
        self.parallel = self.parallel or os.cpu_count()

    def build_extension(self, ext: Extension) -> None:
        """Compile one module, or take what was compiled from the same sources."""
        made = Path(self.get_ext_fullpath(ext.name))
        kept = BUILD / "compiled" / self._digest(ext) / made.name
        if not kept.exists():
            with self._cython:
                (c,) = cythonize(
                    [ext], build_dir=(BUILD / "c").as_posix(), language_level=3, quiet=True, force=True
                )
            ext.sources = c.sources
            super().build_extension(ext)
            kept.parent.mkdir(parents=True, exist_ok=True)
            part = kept.with_name(f"{kept.name}.{os.getpid()}")  # whole, or not there
            shutil.copy2(made, part)
            part.replace(kept)
        else:
            made.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(kept, made)  # new, so that it takes the place of a later one in the tree

    @staticmethod
    def _digest(ext: Extension) -> str:
        read = [Path(__file__), *map(Path, ext.sources), *sorted(SOURCES.rglob("*.pxd"))]
        chosen = [os.environ.get(name, "") for name in ("CC", "CFLAGS", "CPPFLAGS", "LDFLAGS", "LDSHARED")]
        which = (Cython.__version__, sys.version, sysconfig.get_platform(), *chosen)
        return hashlib.sha256(repr(which).encode() + b"".join(path.read_bytes() for path in read)).hexdigest()


def remove_old(modules: list[Extension]) -> None:
    """Remove what earlier builds left of modules that are no more, or are not compiled any more."""
    for folder in BUILD.glob("lib*"):
        shutil.rmtree(folder)
    current = {Path(extension.sources[0]).with_suffix("") for extension in modules}
    for pattern in ("*.so", "*.pyd"):
        for library in SOURCES.rglob(pattern):
            if library.with_name(library.name.split(".")[0]) not in current:
                library.unlink()


MODULES = compiled_modules()
remove_old(MODULES)
setup(
    ext_modules=MODULES,
    cmdclass={"build_ext": Compile},
    options={} if FREE_THREADED else {"bdist_wheel": {"py_limited_api": "cp311"}},
)
