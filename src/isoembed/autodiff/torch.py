"""Registration of the embedding as a differentiable PyTorch function."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from isoembed.autodiff.realization import Realization
from isoembed.embedding.embedding import Embedding


def realization(surface: Embedding) -> Callable[[torch.Tensor], torch.Tensor]:
    """Make the function from lengths to vertices near a surface, for PyTorch in double precision.

    Parameters
    ----------
    surface : Embedding
        Converged, in R^3.

    Returns
    -------
    callable
        Takes lengths (..., E), doubles in the order of the metric's edges, and returns vertices (..., V, 3),
        turned and moved onto those of the surface.  Derivatives are first ones; the forward pass keeps the
        factors that they take, so that a backward pass takes two solves for each surface.

    Raises
    ------
    TypeError
        The lengths are not doubles.
    """
    known, n = Realization(surface), len(surface.vertices)

    class Vertices(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, lengths: torch.Tensor) -> torch.Tensor:
            if lengths.dtype != torch.float64:
                raise TypeError(f"the lengths are {lengths.dtype}, not torch.float64")
            rows = lengths.detach().cpu().numpy().reshape(-1, lengths.shape[-1])
            if lengths.requires_grad:
                ctx.surfaces = [known.linearized(row) for row in rows]
                found = [each.vertices for each in ctx.surfaces]
            else:
                found = [known(row) for row in rows]
            shape = (*lengths.shape[:-1], n, 3)
            return torch.from_numpy(np.array(found).reshape(shape)).to(lengths.device)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, gradient: torch.Tensor) -> torch.Tensor:
            rows = gradient.detach().cpu().numpy().reshape(-1, n, 3)
            pulled = [each.vjp(row) for each, row in zip(ctx.surfaces, rows, strict=True)]
            shape = (*gradient.shape[:-2], len(surface.metric.edges))
            return torch.from_numpy(np.array(pulled).reshape(shape)).to(gradient.device)

    return Vertices.apply
