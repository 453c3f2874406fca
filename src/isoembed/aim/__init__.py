"""Adiabatic isometric mapping: uniformize, embed where it is easy, pull back to the given metric.

One file per step of the paper's section 2; `paper` is the method as printed, `adaptive` the default.
"""
