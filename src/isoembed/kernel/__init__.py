"""Functions that are compiled when it pays, and until then run as the Python that they are."""

from collections.abc import Callable
from typing import Any

from isoembed.kernel.choice import Kernel
from isoembed.kernel.numba_hooks import with_numba

__all__ = ["kernel", "with_numba"]


def kernel(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Decorator of functions that numba compiles when it pays.

    To compile a function takes numba .06 s and .015 s for each of its lines, many times what the function
    itself takes for a few hundred vertices.  So it runs as Python until that took as long as compiling it
    would, or until a call is expected to (`isoembed.kernel.worth`), and compiled from then on.  Compiled code
    is kept for later processes: in the folder that ``NUMBA_CACHE_DIR`` names, else beside the source, else in
    the user's cache folder, else, where all of these cannot be written to, as to services without a home, in
    a folder below the temporary one.  To load it is cheap, and done sooner.  A kernel that compiled ones call
    is compiled with them.  numba is not imported before it is needed.

    Either way a kernel does the same, to the last bit, so that nothing depends on when it was compiled.  (Not
    so `isoembed.linalg.fronts`, which adds up in another order; its matrices are so large that it is always
    compiled.)  For Python, this decorator sees to it that

    - floats among the arguments become NumPy's, of which no error is raised: a division by zero is infinite
      or NaN, as it is in compiled code.  (As an exception it would be another way out of a function, on which
      numba counts the references to every array of a named tuple: to flip 100,000 vertices to Delaunay then
      takes 40 % longer than with loose arrays.)
    - what is returned are Python's numbers, alone or in a tuple.

    Whoever writes a kernel sees to it that

    - no Python number is divided by one that may be zero: one of the two is an element of an array, an
      argument that is a float or what a function of NumPy returned.
    - roundings are those of numba: `math` has its arc tangent, sine and cosine, and raises errors where they
      are not finite; NumPy has its square root and `hypot`.  Squares are products, sums are loops, and no
      complex numbers are divided, nor their `abs` taken.
    - nothing is printed or raised.
    - nothing rests on the overflow of integers: numba adds int32 as int64, NumPy does not.
    - arguments are arrays, numbers and named tuples of them, which do not hold named tuples, and are not
      given by name.

    The environment variable ``ISOEMBED_KERNELS`` is for tests: ``interpreted`` has only those calls compiled
    that would take seconds, ``compiled`` all of them.

    Parameters
    ----------
    function : callable
    **options
        Of `numba.njit`.
    """
    if function is None:
        return lambda function: Kernel(function, options)
    return Kernel(function, options)
