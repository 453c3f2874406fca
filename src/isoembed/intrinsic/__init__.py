"""Intrinsic triangulations: half-edge tables with lengths, flips, Delaunay, vertex removal and insertion.

Vertices are removed and inserted, edges are traced and kept as paths.  What does not change is in
`isoembed.metric`.
"""
