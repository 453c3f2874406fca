"""Adiabatic isometric mapping: uniformize, embed the uniform metric, pull back to the given one.

One file per step of the paper's section 2; `paper` is the method as printed, `adaptive` the default.
"""
