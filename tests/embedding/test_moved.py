"""Old names of embeddings: they warn, and mean what they meant."""

import copy

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.embedding.moved import FUNCTIONS, OF_SENSITIVITY, ON_SURFACE


@pytest.fixture(scope="module")
def body():
    return isoembed.embed(isoembed.PolyhedralMetric.from_mesh(*zoo.icosphere(1)), method="alexandrov")


def old(embedding, name):
    with pytest.warns(DeprecationWarning, match=rf"embedding\.{name} is .*{name}|{name} is .* now"):
        return getattr(embedding, name)


@pytest.mark.parametrize("name", sorted({*ON_SURFACE, *OF_SENSITIVITY, *FUNCTIONS}))
def test_every_old_name_says_where_it_went(body, name):
    with pytest.warns(DeprecationWarning, match=rf"^embedding\.{name} is .* now; .* version 0\.5$") as caught:
        getattr(body, name)
    assert caught[0].filename == __file__


def test_old_names_mean_what_they_meant(body):
    assert old(body, "roughness") == body.surface.roughness
    assert np.array_equal(old(body, "face_sides"), body.surface.flat_faces.sides)
    assert old(body, "report") == isoembed.report(body)
    assert old(body, "certificate") is isoembed.certify(body)
    assert old(body, "comparison")(body).report == isoembed.compare(body, body).report
    changes = np.linspace(0.0, 1.0, len(body.lengths))
    assert np.array_equal(old(body, "jvp")(changes), isoembed.Sensitivity(body).jvp(changes))


def test_names_that_never_were_are_no_attributes(body):
    with pytest.raises(AttributeError, match="'ConvexPolyhedron' object has no attribute 'smoothness'"):
        _ = body.smoothness
    assert copy.copy(body).vertices is body.vertices


class Broken(isoembed.Embedding):
    """An embedding whose property fails."""

    @property
    def area(self):
        return self.vertices.size.missing

    @property
    def report(self):
        return self.no_such_thing


def test_errors_inside_properties_are_not_missing_names(body):
    broken = Broken(body.metric, body.vertices, method="given", tolerance=1e-9)
    with pytest.raises(AttributeError, match="'int' object has no attribute 'missing'"):
        _ = broken.area
    with pytest.raises(AttributeError, match="no attribute 'no_such_thing'"):  # and no old name either
        _ = broken.report


def test_embeddings_have_thirty_names_at_most():
    assert len([name for name in dir(isoembed.Embedding) if not name.startswith("_")]) <= 30
