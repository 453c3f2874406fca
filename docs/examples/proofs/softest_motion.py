"""How firmly lengths hold a surface.

The smallest singular value of the rigidity matrix says how little the lengths change in the softest motion. A
long ellipsoid is held less firmly than a round one.
"""

import numpy as np
from matplotlib.figure import Figure

import isoembed
from isoembed.gallery import Ellipsoid, triangulate

longest, values = np.array([1.0, 1.5, 2.0, 3.0, 4.0]), []
for length in longest:
    metric = isoembed.PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((length, 1, 1)), 150))
    values.append(isoembed.Sensitivity(isoembed.embed(metric)).smallest_singular_value)
assert values[0] > 2 * values[-1] > 0
picture = Figure(figsize=(6, 4))
axes = picture.subplots()
axes.plot(longest, values, "o-")
axes.set(xlabel="longest axis", ylabel="smallest singular value")
picture.savefig("softest_motion.png", dpi=150)
