"""A triangle folded shut.

Each side of a paper triangle is folded at its middle. If the triangle is acute this makes a tetrahedron with
four equal faces, whose volume has a closed form.
"""

import isoembed
from isoembed.gluing import triangle
from isoembed.plot import write_picture

a, b, c = 4.0, 5.0, 6.0
solid = isoembed.embed(
    isoembed.glue([triangle(a, b, c)], [((0, k), (0, k)) for k in range(3)]), method="alexandrov"
)
x, y, z = a * a / 4, b * b / 4, c * c / 4  # squares of the sides of a face
exact = ((x + y - z) * (y + z - x) * (z + x - y) / 72) ** 0.5
assert abs(solid.volume - exact) < 1e-9
write_picture("folded_triangle.png", solid)
