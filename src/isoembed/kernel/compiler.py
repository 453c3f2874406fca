"""Compiled functions: numba's, and how their code is kept.  To import this imports numba."""

import pickle
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from llvmlite.binding import parse_bitcode  # type: ignore[import-untyped]
from numba.core.caching import CompileResultCacheImpl, FunctionCache, InTreeCacheLocator
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys

from isoembed.kernel.numba_hooks import tell_numba
from isoembed.kernel.place import place_of
from isoembed.kernel.worth import NotWorth

_Numbas: Any = CPUDispatcher  # which has more than its stubs say


class Dispatcher(_Numbas):
    """That of numba, which asks before it compiles or loads anything for a call from Python."""

    kernel: Any = None

    def _compile_for_args(self, *args: Any, **named: Any) -> Any:
        if self.kernel is None:
            return super()._compile_for_args(*args, **named)
        if not self.kernel.pays(args):
            raise NotWorth
        entry = super()._compile_for_args(*args, **named)
        self.kernel.account.close()
        return entry


def dispatcher(kernel: Any) -> Dispatcher:
    """Return the dispatcher of a kernel; nothing calls it from C."""
    always = {"nopython": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    made = Dispatcher(kernel.py_func, targetoptions=always | kernel.targetoptions)
    made.kernel = kernel
    with suppress(OSError, RuntimeError):  # there is no place for it
        made._cache = _Cache(kernel.py_func)
    return made


class _Locator(InTreeCacheLocator):
    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator | None":
        place = place_of(Path(py_file).parent)
        if place is None or not Path(py_file).exists():
            return None
        self = cls(py_func, py_file)
        self._cache_path = str(place)
        return self


class _Library(JITCodeLibrary):
    """Machine code that was kept; its bitcode is read when other functions are compiled with it, if ever."""

    _bitcode: bytes | None = None

    @classmethod
    def _unserialize(cls, codegen: Any, kept: Any) -> Any:
        name, kind, data = kept
        if kind != "object":
            return super()._unserialize(codegen, kept)
        self = cls(codegen, name)
        machine_code, self._bitcode = data
        self.enable_object_caching()
        self._set_compiled_object(machine_code)
        self._finalize_final_module()
        return self

    def _get_module_for_linking(self) -> Any:
        if self._bitcode is not None:
            self._shared_module, self._bitcode = parse_bitcode(self._bitcode), None
            self._codegen._engine._load_defined_symbols(self._shared_module)
        return super()._get_module_for_linking()

    def get_pointer_to_function(self, name: str) -> int:
        if self._bitcode is None:
            return super().get_pointer_to_function(name)
        return self._codegen._engine.get_function_address(name)


def _is_plain(constant: Any) -> bool:
    return isinstance(constant, np.dtype) and constant.isnative and constant.kind in "biufc"


class _Implementation(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012

    def reduce(self, compiled: Any) -> Any:
        # To load an environment is to import its module: of numba's own functions all that implements arrays,
        # and scipy.linalg with it, .04 s.  Machine code takes constants from environments, and asks for those
        # without any only where it prints, or raises with arguments known at run time: kernels do neither.
        *kept, environments = super().reduce(compiled)
        return (*kept, tuple(environment for environment in environments if environment.consts))

    def rebuild(self, target: Any, kept: Any) -> Any:
        # Types that were pickled are copies, of whose arrays NumPy does not know at once that it is quick.
        consts = kept[2].consts
        consts[:] = [np.dtype(each.type) if _is_plain(each) else each for each in consts]
        codegen = target.codegen()
        numbas, codegen._library_class = codegen._library_class, _Library
        try:
            return super().rebuild(target, kept)
        finally:
            codegen._library_class = numbas


class _Cache(FunctionCache):
    """The kept code of a function.  If it cannot be read or written, the function is compiled anew."""

    _impl_class = _Implementation

    def load_overload(self, signature: Any, target: Any) -> Any:
        # numba would import all that it can compile first, .2 s that machine code has no need of.
        rtsys.initialize(target)
        try:
            with self._guard_against_spurious_io_errors():
                return self._load_overload(signature, target)
            return None
        except OSError:  # closed to us
            return None
        except (EOFError, pickle.UnpicklingError, AttributeError, ImportError):
            # Cut short, or compiled for types that an older version had in another place.
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, *compiled: Any) -> None:
        with suppress(OSError, EOFError, pickle.UnpicklingError):  # a full disk, and what it left
            super().save_overload(*compiled)


tell_numba()
