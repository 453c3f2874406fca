"""Pictures of surfaces by the ending of the file."""

from pathlib import Path

import zoo
from isoembed import PolyhedralMetric, embed


def test_a_surface_is_saved_as_a_picture(tmp_path: Path):
    cube = embed(PolyhedralMetric.from_mesh(*zoo.cube()), method="alexandrov")
    cube.save(tmp_path / "sides.svg")
    assert "number of sides of a face" in (tmp_path / "sides.svg").read_text()
    cube.save(tmp_path / "residual.svg", color="residual")
    assert "number of sides" not in (tmp_path / "residual.svg").read_text()
