"""Registration of the embedding as a differentiable PyTorch function."""

from collections.abc import Callable
from typing import Any

import numpy as np

try:
    import torch
except ImportError:
    raise ImportError("isoembed.autodiff.torch needs PyTorch: pip install torch") from None

from isoembed.autodiff.realization import Realization
from isoembed.embedding.embedding import Embedding


def realization(surface: Embedding) -> Callable[..., torch.Tensor]:
    """Create a PyTorch function from lengths to vertices near a surface, in double precision.

    Parameters
    ----------
    surface : Embedding
        Converged surface in R^3: closed and of genus 0, or a `SheetEmbedding`.

    Returns
    -------
    callable
        Takes lengths (..., E), doubles in the order of the metric's edges, and returns vertices (..., V, 3),
        aligned with those of the surface, like `isoembed.autodiff.realization.Realization`.  If heights (B,)
        or positions (B, 3) are given at a boundary, ``boundary=`` replaces them, for all lengths alike.
        Only first derivatives are supported; the forward pass stores their factors, so that a backward pass
        takes two solves per surface.

    Raises
    ------
    TypeError
        The lengths are not doubles.
    """
    nearby, n = Realization(surface), len(surface.vertices)

    class Vertices(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, lengths: torch.Tensor, boundary: torch.Tensor) -> torch.Tensor:
            for name, tensor in (("lengths", lengths), ("boundary data", boundary)):
                if tensor.dtype != torch.float64:
                    raise TypeError(f"the {name} are {tensor.dtype}, not torch.float64")
            rows = lengths.detach().cpu().numpy().reshape(-1, lengths.shape[-1])
            boundary_data = boundary.detach().cpu().numpy()
            if lengths.requires_grad or boundary.requires_grad:
                ctx.surfaces = [nearby.linearized(row, boundary_data) for row in rows]
                found = [each.vertices for each in ctx.surfaces]
            else:
                found = [nearby(row, boundary_data) for row in rows]
            shape = (*lengths.shape[:-1], n, 3)
            return torch.from_numpy(np.array(found).reshape(shape)).to(lengths.device)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, gradient: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
            rows = gradient.detach().cpu().numpy().reshape(-1, n, 3)
            pulled = [each.vjp(row) for each, row in zip(ctx.surfaces, rows, strict=True)]
            shape = (*gradient.shape[:-2], len(surface.metric.edges))
            at_boundary = sum(each.boundary_vjp(row) for each, row in zip(ctx.surfaces, rows, strict=True))
            by_lengths = torch.from_numpy(np.array(pulled).reshape(shape)).to(gradient.device)
            return by_lengths, torch.from_numpy(np.array(at_boundary)).to(gradient.device)

    own = torch.from_numpy(np.array(nearby.boundary))

    def vertices(lengths: torch.Tensor, boundary: torch.Tensor | None = None) -> torch.Tensor:
        return Vertices.apply(lengths, own if boundary is None else boundary)

    return vertices
