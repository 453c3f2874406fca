"""A function, and the choice between its compiled code and Python."""

import atexit
import os
import sys
import threading
import time
from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any

import numpy as np

from isoembed.kernel import ledger
from isoembed.kernel.place import is_kept
from isoembed.kernel.worth import IMPORTING, LOADING, Account, NotWorth, elements, lasting, source_lines

WHEN = os.environ.get("ISOEMBED_KERNELS", "")
"""To compile: ``compiled`` at once, ``interpreted`` what would take seconds, otherwise what pays."""

_clock = time.thread_time


class _Thread(threading.local):
    interpreting = False  # a kernel, whose calls of others are part of it


_THREAD = _Thread()
_ALL = Account()
_interpreted: list["Kernel"] = []


class Kernel:
    """A function that `isoembed.kernel.kernel` decorates.

    Attributes
    ----------
    py_func : callable
        As it was written.
    targetoptions : dict
        Options of numba, which looks for them here.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.targetoptions = options
        self._run: Callable[..., Any] = self._choose

    def __call__(self, *args: Any) -> Any:
        """Run the function."""
        try:
            return self._run(*args)
        except NotWorth:  # it is compiled, but for other types
            return self._interpret(args)

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __repr__(self) -> str:
        return f"kernel({self.py_func!r})"

    @property
    def name(self) -> str:
        """Under which it is known to other processes."""
        return f"{self.py_func.__module__}.{self.py_func.__qualname__}"

    @cached_property
    def account(self) -> Account:
        """What it took as Python."""
        _interpreted.append(self)
        return Account(ledger.earlier().get(self.name, 0.0))

    @cached_property
    def dispatcher(self) -> Any:
        """That of numba, which is imported for it."""
        from isoembed.kernel.compiler import dispatcher

        return dispatcher(self)

    @property
    def _numba_type_(self) -> Any:  # as what functions that call it know it
        return self.dispatcher._numba_type_

    @property
    def stats(self) -> Any:
        """Where its code is kept, and how often it was found there: numba's."""
        return self.dispatcher.stats

    def pays(self, args: tuple[Any, ...]) -> bool:
        """Whether the function is to be compiled, or loaded, for arguments like these."""
        if WHEN == "compiled":
            return True
        if _THREAD.interpreting:
            return False
        expected = self.account.expected(elements(args), self._lines)
        if WHEN == "interpreted":
            return expected > 3.0  # seconds: longer calls are compiled where no others are, in tests
        importing = 0.0 if "numba" in sys.modules else max(0.0, IMPORTING - _ALL.seconds)
        spent = 2.0 * self.account.earlier + self.account.seconds  # what was run twice will be run again
        return spent + expected > self._price + importing

    def _choose(self, *args: Any) -> Any:
        if not self.pays(args):
            return self._interpret(args)
        self._run = self.dispatcher
        return self._run(*args)

    def _interpret(self, args: tuple[Any, ...]) -> Any:
        if _THREAD.interpreting:
            return self.py_func(*args)
        begun = _clock()
        _THREAD.interpreting = True
        try:
            with np.errstate(all="ignore"):
                result = self.py_func(*[np.float64(arg) if type(arg) is float else arg for arg in args])
        finally:
            _THREAD.interpreting = False
            seconds, size = _clock() - begun, elements(args)
            for account in (self.account, _ALL):
                account.enter(seconds, size)
        return _plain(result)

    @cached_property
    def _with_callees(self) -> set["Kernel"]:
        """The function itself, and whatever is compiled with it."""
        found: set[Kernel] = set()
        rest = [self]
        while rest:
            kernel = rest.pop()
            if kernel not in found:
                found.add(kernel)
                names = map(kernel.py_func.__globals__.get, kernel.py_func.__code__.co_names)
                rest += [known for known in names if isinstance(known, Kernel)]
        return found

    @cached_property
    def _lines(self) -> int:
        return sum(source_lines(kernel.py_func.__code__) for kernel in self._with_callees)

    @cached_property
    def _price(self) -> float:
        """Seconds that compiled code takes, numba given."""
        if is_kept(self.py_func):
            return LOADING
        new = [kernel.py_func.__code__ for kernel in self._with_callees if not is_kept(kernel.py_func)]
        # seconds to compile a function, and for each of its lines
        return sum(0.06 + 0.015 * source_lines(code) for code in new)


@atexit.register
def _write() -> None:
    """Let later processes know what compiled code would have saved this one."""
    if WHEN:
        return
    numba = "numba" in sys.modules
    spent = {
        kernel.name: lasting(kernel.account.seconds, _ALL.seconds, numba)
        for kernel in _interpreted
        if not is_kept(kernel.py_func)
    }
    compiled = {kernel.name for kernel in _interpreted if kernel.account.compiled}
    ledger.write({name: seconds for name, seconds in spent.items() if seconds > 0}, compiled)


def _plain(result: Any) -> Any:
    """Python's numbers for those of NumPy, as compiled functions return them."""
    if isinstance(result, np.generic):
        return result.item()
    if isinstance(result, tuple):
        items = [_plain(item) for item in result]
        return tuple(items) if type(result) is tuple else type(result)(*items)
    return result
