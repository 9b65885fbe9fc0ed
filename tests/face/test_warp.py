"""Laws of piecewise-affine warps."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from phonanim.errors import MissingExtraError
from phonanim.face.warp import Mesh, build_mesh, sample_bilinear

SQUARE = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 16.0], [0.0, 16.0], [9.0, 7.0]])


@pytest.fixture
def mesh() -> Mesh:
    return build_mesh(SQUARE)


def ramp(height: int, width: int) -> np.ndarray:
    down, right = np.mgrid[:height, :width]
    return np.stack([2.0 * right + 30, 3.0 * down + 10, right + down], axis=2)


def test_the_triangles_cover_the_shape(mesh: Mesh) -> None:
    assert len(mesh.triangles) == 4
    assert len(mesh.pixels) == pytest.approx(21 * 17, abs=2 * (21 + 17))
    assert np.allclose(mesh.weights.sum(axis=1), 1, atol=1e-5)
    assert (mesh.weights > -1e-4).all()


def test_the_shape_has_a_margin_on_every_side(mesh: Mesh) -> None:
    assert mesh.reference.min(axis=0).tolist() == [2.0, 2.0]
    assert (mesh.width, mesh.height) == (20 + 2 * 2 + 1, 16 + 2 * 2 + 1)


def test_pixels_go_where_the_landmarks_go(mesh: Mesh) -> None:
    row, column = np.divmod(mesh.pixels, mesh.width)
    at_rest = np.column_stack([column, row])
    turned = np.array([[0.8, 0.3], [-0.3, 0.8]])
    places = mesh.places((mesh.reference @ turned + [5, 9])[None])[0]
    assert np.allclose(places, at_rest @ turned + [5, 9], atol=1e-4)


def test_a_texture_holds_the_levels_of_the_picture(mesh: Mesh) -> None:
    image, landmarks = ramp(60, 70), SQUARE * 1.7 + [8, 5]
    texture = mesh.cut(image[None], landmarks[None])[0]
    x, y = mesh.places(landmarks[None])[0].T
    assert np.allclose(texture, np.stack([2 * x + 30, 3 * y + 10, x + y], axis=1), atol=1e-3)


def test_draw_undoes_cut(mesh: Mesh) -> None:
    image, landmarks = ramp(40, 50), SQUARE * 1.3 + [6.2, 4.7]
    canvas = np.full(image.shape, 255, np.uint8)
    drawn = mesh.draw(mesh.cut(image[None], landmarks[None])[0], landmarks, canvas)
    inside = (slice(7, 23), slice(9, 30))
    assert np.abs(drawn[inside].astype(float) - image[inside]).max() <= 1.5
    assert (drawn[:3] == 255).all()


def test_a_triangle_that_is_turned_over_is_not_drawn(mesh: Mesh) -> None:
    white = np.full((len(mesh.pixels), 3), 255.0)
    drawn = mesh.draw(white, SQUARE[:, ::-1] + 3, np.zeros((30, 30, 3), np.uint8))
    assert not drawn.any()


def test_sampling_between_and_beyond_pixels() -> None:
    image = np.array([[[0.0], [10.0]], [[20.0], [30.0]]])
    places = np.array([[0, 0], [0.5, 0.5], [1, 1], [-4, 9], [7, -2]])
    assert sample_bilinear(image, places)[:, 0].tolist() == [0.0, 15.0, 30.0, 20.0, 10.0]


def test_without_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    with pytest.raises(
        MissingExtraError, match=r"an appearance model needs scipy: pip install 'phonanim\[train\]'"
    ):
        build_mesh(SQUARE)
