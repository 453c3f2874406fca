"""Intrinsic triangulations: half-edge tables with lengths, Delaunay flips, vertex removal and insertion.

Also traces edges as geodesic paths.  Immutable metrics are in `isoembed.metric`.
"""
