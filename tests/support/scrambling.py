"""Random flips."""

from isoembed.intrinsic.loops import flip


def scramble(mesh, flips, rng, thinnest=1e-3):
    """Flip random edges, of those whose flip leaves no triangle thinner than asked; return how many."""
    views = mesh.views
    return sum(flip(h, views, thinnest) for h in rng.integers(0, mesh.corners.size, flips))
