"""A crease pattern folds itself up.

Six squares and the angles of their creases, as origami programs write them in FOLD. Nobody says what is
glued: sides that meet when the sheet is folded are.
"""

import json
from pathlib import Path

import isoembed
from isoembed.io.net import read_net

points = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [0, 1], [1, 1], [2, 1], [3, 1], [4, 1]]
points += [[1, 2], [2, 2], [1, -1], [2, -1]]
faces = [[0, 1, 6, 5], [1, 2, 7, 6], [2, 3, 8, 7], [3, 4, 9, 8], [6, 7, 11, 10], [12, 13, 2, 1]]
sheet = {
    "vertices_coords": points,
    "faces_vertices": faces,
    "edges_vertices": [[1, 6], [2, 7], [3, 8], [6, 7], [1, 2]],
    "edges_foldAngle": [-90] * 5,  # mountains
}
Path("sheet.fold").write_text(json.dumps(sheet), encoding="utf-8")
cube = isoembed.embed(read_net("sheet.fold"), method="alexandrov")
assert len(cube.polygons) == 6 and abs(cube.volume - 1) < 1e-12
cube.plot(color="sides", caption="folded from the angles of five creases").savefig("folded_up.png", dpi=220)
