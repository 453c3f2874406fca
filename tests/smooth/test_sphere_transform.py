"""Fast transforms against tables of harmonics at nodes."""

import numpy as np
import pytest

from isoembed.smooth.harmonics import Harmonics
from isoembed.smooth.sphere_transform import SphereTransform
from isoembed.smooth.two_metric import angle_frame

CASES = [
    (Harmonics(0, 0), 2, 1),
    (Harmonics(9, 9), 10, 20),
    (Harmonics(24, 1), 30, 8),
    (Harmonics(12, 5), 17, 11),
]


@pytest.mark.parametrize(("harmonics", "n", "around"), CASES)
def test_synthesis(harmonics: Harmonics, n: int, around: int) -> None:
    transform = SphereTransform(harmonics, n, around)
    C = np.random.default_rng(0).normal(size=(harmonics.size, 2))
    e = np.stack(angle_frame(transform.u), axis=1)
    Y, first = harmonics.along(transform.u, e)
    second = harmonics.second_along(transform.u, e, C)
    pairs = np.stack([second[:, 0, 0], second[:, 0, 1], second[:, 1, 1]], axis=1)
    L = harmonics.degree + 1
    assert np.abs(transform.values(C) - Y @ C).max() < 1e-13 * L
    assert np.abs(transform.gradients(C) - first @ C).max() < 1e-13 * L**2
    assert np.abs(transform.hessians(C) - pairs).max() < 1e-13 * L**3


@pytest.mark.parametrize(("harmonics", "n", "around"), CASES)
@pytest.mark.parametrize("kind", ["values", "gradients", "hessians"])
def test_adjoint(harmonics: Harmonics, n: int, around: int, kind: str) -> None:
    transform = SphereTransform(harmonics, n, around)
    rng = np.random.default_rng(1)
    C = rng.normal(size=(harmonics.size, 3))
    there = getattr(transform, kind)(C)
    f = rng.normal(size=there.shape)
    back = getattr(transform, f"adjoint_{kind}")(f)
    scale = np.linalg.norm(there) * np.linalg.norm(f)
    assert abs(np.sum(f * there) - np.sum(back * C)) < 1e-14 * (scale + 1e-300)


def test_analysis_is_the_inverse_of_synthesis() -> None:
    harmonics = Harmonics(60, 60)
    transform = SphereTransform(harmonics, 61, 122)
    C = np.random.default_rng(2).normal(size=(harmonics.size, 1))
    assert np.abs(transform.analysis(transform.values(C)) - C).max() < 1e-12


@pytest.mark.parametrize("order", [0, 1, 3])
def test_complex_harmonics_on_the_meridian(order: int) -> None:
    transform = SphereTransform(Harmonics(7, 3), 9, 8)
    orders = transform.harmonics.labels[1]
    norm = np.sqrt(2.0) if order else 1.0
    for kind, found in zip(("values", "gradients", "hessians"), transform.on_meridian(order), strict=True):
        table = getattr(transform, kind)(np.eye(transform.harmonics.size))[::8]  # at phi = 0
        exact = table[..., orders == order] + (1j * table[..., orders == -order] if order else 0.0)
        ratio = np.abs(found).max() / np.abs(exact).max()
        assert min(abs(ratio - 1.0), abs(ratio - norm), abs(ratio * norm - 1.0)) < 1e-13
        assert found == pytest.approx(ratio * exact, abs=1e-11)


def test_too_few_angles() -> None:
    with pytest.raises(ValueError, match="8 angles are too few for the order 4"):
        SphereTransform(Harmonics(4, 4), 5, 8)
