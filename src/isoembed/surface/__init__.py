"""Extrinsic geometry: coordinates in space, and what can be measured on them.

The room's noun is `Embedding`; the measures are functions of a triangulation and its vertices.
"""
