"""Tasks for tests of runs: what they do is written in them, so that processes can be told to die."""

import hashlib
import os
import signal
import time
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.io import FileError
from isoembed.runs import Result


@dataclass(frozen=True)
class Square:
    """The square of a number, and the sum of those before it in its chunk.

    Where there is a folder, every call leaves a file in it.
    """

    number: int
    calls: Path | None = None
    fails: str = ""
    options: str = ""

    @property
    def label(self) -> str:
        return f"square{self.number}"

    @property
    def facts(self):
        return {"number": self.number}

    def digest(self) -> str:
        if self.fails == "unreadable":
            raise FileError(f"there is no file {self.label}")
        if self.fails == "no digest":
            raise InvalidParameter(f"{self.label} cannot be pickled")
        if self.fails == "digest in memory":
            raise MemoryError
        return hashlib.sha256(f"{self.number} {self.fails} {self.options}".encode()).hexdigest()

    def compute(self, before: Result | None) -> Result:
        if self.calls is not None:
            with (self.calls / self.label).open("a") as file:
                file.write("x")
        if self.fails == "no answer":
            return Result.without_answer(self.label, "none", f"{self.number} has no square")
        if self.fails == "memory":
            raise MemoryError
        if self.fails == "mistake":
            raise ZeroDivisionError("a mistake")
        if self.fails == "killed" or (self.fails == "killed once" and self._count() == 1):
            os.kill(os.getpid(), signal.SIGKILL)
        total = 0.0 if before is None else before.report["total"]
        square = float(self.number) ** 2
        return Result(
            self.label,
            "done",
            {"square": square, "total": total + square / 3.0, "process": os.getpid()},
            {"square": np.array([square])},
        )

    def _count(self) -> int:
        assert self.calls is not None
        return len((self.calls / self.label).read_text())


@dataclass(frozen=True)
class Slow(Square):
    """One that takes some time."""

    seconds: float = 0.1

    def compute(self, before: Result | None) -> Result:
        time.sleep(self.seconds)
        return super().compute(before)


class Here(Executor):
    """An executor that does everything at once in this process, for tests of what is done."""

    def __init__(self, jobs=None):
        pass

    def submit(self, function, /, *args, **options):
        future = Future()
        future.set_result(function(*args, **options))
        return future
