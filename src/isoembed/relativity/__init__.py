"""Relativity: horizons and other surfaces in slices of spacetime, and their quasi-local energies.

Units are geometric, G = c = 1.  The mean curvature of relativity is the trace k = k1 + k2.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
