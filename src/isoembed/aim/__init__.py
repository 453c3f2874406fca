"""Adiabatic isometric mapping: uniformize, embed where it is easy, pull back to the given metric.

The steps of the paper's section 2, and what the default method does in place of each:

- 2.1, `uniformize`: `convexification`, only as far as convexity;
- 2.2, `embedding_tree`, `anneal`, `convexity`: `isoembed.alexandrov`, the polyhedron of a convex metric;
- 2.3, `adiabatic_pullback`, `paths`: `newton_on_lengths` at once, `patch_reflections` where there are dents,
  else `regularized_continuation`, or `levels` of many vertices.

Convex metrics go by `newton_on_radii` or `newton_from_polytope` at once.  What the pull-back missed is for
`local_search`, `best_fit` and `reflection_search`; which of several surfaces is returned, for `choice`.
`paper` is the method as printed, `adaptive` the default; `strategies` has its order, `pipeline` runs it.
"""
