"""Registration of the embedding as a differentiable JAX function."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    raise ImportError("isoembed.autodiff.jax needs JAX: pip install jax") from None

from isoembed.arrays import Floats
from isoembed.autodiff.realization import Linearized, Realization
from isoembed.embedding.embedding import Embedding


def realization(surface: Embedding) -> Callable[..., jax.Array]:
    """Create a JAX function from lengths to vertices near a surface, in double precision.

    Parameters
    ----------
    surface : Embedding
        Converged surface in R^3: closed and of genus 0, or a `SheetEmbedding`.

    Returns
    -------
    callable
        Takes lengths (E,), in the order of the metric's edges, and returns vertices (V, 3), aligned with
        those of the surface, like `isoembed.autodiff.realization.Realization`.  If heights (B,) or positions
        (B, 3) are given at a boundary, ``boundary=`` replaces them.  The function supports `jax.jit`,
        `jax.grad` and `jax.vmap` (sequentially), and first derivatives only.  The factors for the last
        lengths are cached: a backward pass takes two solves.

    Raises
    ------
    RuntimeError
        JAX has single precision only: set ``jax.config.update("jax_enable_x64", True)`` first.
    """
    if not jax.config.jax_enable_x64:
        raise RuntimeError('lengths are doubles: jax.config.update("jax_enable_x64", True) first')
    nearby, n, count = Realization(surface), len(surface.vertices), len(surface.metric.edges)
    shape = nearby.boundary.shape
    placed = jax.ShapeDtypeStruct((n, 3), jnp.float64)
    pulled = tuple(jax.ShapeDtypeStruct(each, jnp.float64) for each in ((count,), shape))

    @lru_cache(maxsize=1)
    def linearized(lengths: bytes, boundary: bytes) -> Linearized:
        return nearby.linearized(np.frombuffer(lengths), np.frombuffer(boundary).reshape(shape))

    def at(lengths: Floats, boundary: Floats) -> Linearized:
        return linearized(np.asarray(lengths).tobytes(), np.asarray(boundary).tobytes())

    def forward(lengths: Floats, boundary: Floats) -> Floats:
        return at(lengths, boundary).vertices

    def backward(lengths: Floats, boundary: Floats, gradient: Floats) -> tuple[Floats, Floats]:
        found, g = at(lengths, boundary), np.asarray(gradient)
        return found.vjp(g), found.boundary_vjp(g)

    @jax.custom_vjp
    def realized(lengths: jax.Array, boundary: jax.Array) -> jax.Array:
        return jax.pure_callback(forward, placed, lengths, boundary, vmap_method="sequential")

    def remembered(lengths: jax.Array, boundary: jax.Array) -> tuple[jax.Array, tuple[jax.Array, jax.Array]]:
        return realized(lengths, boundary), (lengths, boundary)

    def pulled_back(given: tuple[jax.Array, jax.Array], gradient: jax.Array) -> tuple[jax.Array, jax.Array]:
        both: tuple[jax.Array, jax.Array] = jax.pure_callback(
            backward, pulled, *given, gradient, vmap_method="sequential"
        )
        return both

    realized.defvjp(remembered, pulled_back)

    def vertices(lengths: jax.Array, boundary: jax.Array | None = None) -> jax.Array:
        return realized(lengths, jnp.asarray(nearby.boundary) if boundary is None else boundary)

    return vertices
