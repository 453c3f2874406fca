"""Registration of the embedding as a differentiable JAX function."""

from collections.abc import Callable
from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np

from isoembed.arrays import Floats
from isoembed.autodiff.realization import Linearized, Realization
from isoembed.embedding.embedding import Embedding


def realization(surface: Embedding) -> Callable[[jax.Array], jax.Array]:
    """Make the function from lengths to vertices near a surface, for JAX in double precision.

    Parameters
    ----------
    surface : Embedding
        Converged, in R^3.

    Returns
    -------
    callable
        Takes lengths (E,), in the order of the metric's edges, and returns vertices (V, 3), turned and moved
        onto those of the surface.  It may be transformed by `jax.jit`, `jax.grad` and `jax.vmap`, which goes
        through a batch one by one; derivatives are first ones.  The factors of the last lengths are kept:
        a backward pass takes two solves.

    Raises
    ------
    RuntimeError
        JAX has single precision only: set ``jax.config.update("jax_enable_x64", True)`` first.
    """
    if not jax.config.jax_enable_x64:
        raise RuntimeError('lengths are doubles: jax.config.update("jax_enable_x64", True) first')
    known, n, count = Realization(surface), len(surface.vertices), len(surface.metric.edges)
    placed, pulled = jax.ShapeDtypeStruct((n, 3), jnp.float64), jax.ShapeDtypeStruct((count,), jnp.float64)

    @lru_cache(maxsize=1)
    def linearized(lengths: bytes) -> Linearized:
        return known.linearized(np.frombuffer(lengths))

    def forward(lengths: Floats) -> Floats:
        return linearized(np.asarray(lengths).tobytes()).vertices

    def backward(lengths: Floats, gradient: Floats) -> Floats:
        return linearized(np.asarray(lengths).tobytes()).vjp(np.asarray(gradient))

    @jax.custom_vjp
    def vertices(lengths: jax.Array) -> jax.Array:
        return jax.pure_callback(forward, placed, lengths, vmap_method="sequential")

    def remembered(lengths: jax.Array) -> tuple[jax.Array, jax.Array]:
        return vertices(lengths), lengths

    def pulled_back(lengths: jax.Array, gradient: jax.Array) -> tuple[jax.Array]:
        return (jax.pure_callback(backward, pulled, lengths, gradient, vmap_method="sequential"),)

    vertices.defvjp(remembered, pulled_back)
    return vertices
