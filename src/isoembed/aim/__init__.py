"""Adiabatic isometric mapping: uniformize, embed where it is easy, pull back to the given metric.

The steps of the paper's section 2, and the replacements of the default method:

- 2.1, `uniformize`: `convexification`, only as far as convexity;
- 2.2, `embedding_tree`, `anneal`, `convexity`: `isoembed.alexandrov`, the polyhedron of a convex metric;
- 2.3, `adiabatic_pullback`, `paths`: `newton_on_lengths` at once, `patch_reflections` where there are dents,
  else `regularized_continuation`, or `levels` of many vertices.

Convex metrics are solved directly by `newton_on_radii` or `newton_from_polytope`.  If the pull-back misses
the lengths, `local_search`, `best_fit` and `reflection_search` follow; `choice` selects among the surfaces.
`paper` is the method as printed, `adaptive` the default; `strategies` has its order, `pipeline` runs it.
"""
