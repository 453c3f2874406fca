"""A surface from a list of numbers.

Eight triangles and twelve lengths, in the order of the edges. No coordinates anywhere.
"""

import isoembed
from isoembed.plot import write_picture

faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
lengths = [1.0, 1.0, 1.2, 1.2, 1.0, 1.0, 1.2, 1.2, 1.2, 1.2, 1.2, 1.2]
metric = isoembed.PolyhedralMetric(faces, lengths)
print(*zip(metric.edges.tolist(), metric.lengths, strict=True), sep="\n")
surface = isoembed.embed(metric)
exact = 2 / 3 * (1.2**2 - 0.5) ** 0.5  # two pyramids over a unit square
assert abs(surface.volume - exact) < 1e-10
write_picture("from_lengths.png", surface)
