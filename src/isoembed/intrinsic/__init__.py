"""A triangulated surface without coordinates that changes: half-edges, flips, Delaunay triangulations.

Vertices are removed and inserted, edges are traced and kept as paths.  What does not change is in
`isoembed.metric`.
"""
