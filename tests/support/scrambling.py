"""Random flips."""

from isoembed.intrinsic.loops import flip
from isoembed.kernel import kernel


def scramble(mesh, flips, rng, thinnest=1e-3):
    """Flip random edges, of those whose flip leaves no triangle thinner than asked; return how many."""
    return flip_some(mesh, rng.integers(0, mesh.corners.size, flips), thinnest)


@kernel
def flip_some(mesh, tried, thinnest):
    """Flip the edges of these half-edges where that leaves no thin triangle; return how many were."""
    flips = 0
    for h in tried:
        flips += flip(h, mesh, thinnest)
    return flips
