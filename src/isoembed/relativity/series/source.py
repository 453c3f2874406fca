"""Sources of horizons and slices: picklable references with a content hash.

A source is pickled to a worker: it holds paths and choices, never an open file.
"""

import hashlib
import pickle
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType
from typing import Any, Protocol

from isoembed.arrays import Floats
from isoembed.io.files import FileError
from isoembed.relativity.horizons.horizon import GivenHorizon
from isoembed.relativity.spacetimes.three_geometry import ThreeGeometry

HELD = "the horizon"


class ShapeSource(Protocol):
    """Source of a horizon: its shape in slice coordinates, or a surface with its own metric."""

    @property
    def name(self) -> str:
        """Name for messages and reports: the path, and the part of the file."""
        ...

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of the content that `read` reads.

        Raises `FileError`: the source cannot be read, or changes meanwhile.
        """
        ...

    def read(self) -> GivenHorizon:
        """Read the horizon.

        Raises `FileError` or `InvalidMetric`: it cannot be read, changes meanwhile, or is invalid;
        one sentence gives the reason.
        """
        ...


class SliceSource(Protocol):
    """Source of a slice, read as far as a surface needs it."""

    @property
    def name(self) -> str:
        """See `ShapeSource.name`."""
        ...

    def digest(self) -> str:
        """Digest of the whole slice: see `ShapeSource.digest`."""
        ...

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """Read the part of the slice that a surface needs.

        Raises `FileError`: as of `ShapeSource`; or the slice does not cover the box.

        Parameters
        ----------
        low, high : ndarray, shape (3,)
            Corners of a box around the surface.  Points around the box needed for interpolation are read as
            well.
        """
        ...


class FileSlice(SliceSource, Protocol):
    """Source of a slice in a file, which can be read without a surface."""

    def whole(self) -> ThreeGeometry:
        """Read the whole slice.  Raises `FileError`: see `ShapeSource.read`."""
        ...


@dataclass(frozen=True)
class HeldShape:
    """Horizon in memory.

    Attributes
    ----------
    shape : CoordinateShape, SurfaceData, StarSurface, MappedSurface or FoundHorizon
    called : str
        Name; by default that of its file, or its own.
    """

    shape: GivenHorizon
    called: str = ""

    @property
    def name(self) -> str:
        """Name of the shape."""
        names = (self.called, *(getattr(self.shape, each, "") for each in ("source", "name")))
        return next(filter(None, names), HELD)

    def digest(self) -> str:
        """See `object_digest`."""
        return object_digest(self.shape)

    def read(self) -> GivenHorizon:
        """The horizon itself."""
        return self.shape


@dataclass(frozen=True)
class HeldSlice:
    """Slice in memory, or in closed form.

    Attributes
    ----------
    geometry : ThreeGeometry
    """

    geometry: ThreeGeometry

    @property
    def name(self) -> str:
        """Name of the type of the slice."""
        return type(self.geometry).__name__

    def digest(self) -> str:
        """See `object_digest`."""
        return object_digest(self.geometry)

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """The whole slice."""
        return self.geometry


@dataclass(frozen=True)
class MissingSlice:
    """Placeholder for a missing slice.

    Attributes
    ----------
    why : str
        A sentence.
    """

    why: str

    @property
    def name(self) -> str:
        """Description of the missing slice."""
        return "no slice"

    def digest(self) -> str:
        """Hash of the reason."""
        return hashlib.sha256(self.why.encode()).hexdigest()

    def read(self, low: Floats, high: Floats) -> ThreeGeometry:
        """Raise `FileError`, always."""
        raise FileError(self.why)


def object_digest(thing: object) -> str:
    """Hash of the data of an object: of its pickle, in which functions and classes count by their names.

    The values of functions are not in it: see `isoembed.relativity.series.sampled_values`.  An object that
    cannot be pickled counts by the name of its class only.
    """
    hashed = _HashedPickle()
    pickler = _Contents(hashed, protocol=4)  # from 5 on pickles tell arrays from views of them
    pickler.fast = True  # without references to earlier objects: equal objects count as the same
    try:
        pickler.dump(thing)
    except (pickle.PicklingError, AttributeError, TypeError, ValueError, RecursionError):
        return hashlib.sha256(_named(type(thing)).encode()).hexdigest()
    return hashed.sha.hexdigest()


def _named(thing: type | FunctionType) -> str:
    return f"{thing.__module__}.{thing.__qualname__}"


class _HashedPickle:
    """File object that hashes the data written to it."""

    def __init__(self) -> None:
        self.sha = hashlib.sha256()

    def write(self, data: bytes) -> int:
        self.sha.update(data)
        return len(data)


class _Contents(pickle.Pickler):
    """Pickler of objects without their cached properties, and of functions and local classes by name."""

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, FunctionType) or (isinstance(thing, type) and "<locals>" in thing.__qualname__):
            return str, (_named(thing),)
        modules = [
            name
            for base in type(thing).__mro__
            for name, value in vars(base).items()
            if isinstance(value, cached_property)
        ]
        if isinstance(thing, type) or not modules:
            return NotImplemented
        make, arguments, state, *rest = thing.__reduce_ex__(4)
        return make, arguments, {name: value for name, value in state.items() if name not in modules}, *rest
