"""Laws of the appearance model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pictured import pictured_face

from phonanim.corpus.pictures import pixel_mse
from phonanim.errors import ModelError
from phonanim.face.appearance import (
    BACKDROP,
    LUMA,
    AppearanceModel,
    inner_mouth,
    load_appearance,
    principal,
    save_appearance,
)
from phonanim.face.model import INNER_LIPS


@pytest.fixture(scope="module")
def model() -> AppearanceModel:
    return pictured_face()


def some_joint(model: AppearanceModel, frames: int = 4) -> np.ndarray:
    return np.random.default_rng(1).normal(size=(frames, len(model.std))) * model.std


def test_project_undoes_instance(model: AppearanceModel) -> None:
    joint = some_joint(model)
    assert np.allclose(model.project(*model.instance(joint)), joint, atol=1e-2 * model.std[0])


def test_modes_are_orthonormal_and_sorted(model: AppearanceModel) -> None:
    assert np.allclose(model.basis @ model.basis.T, np.eye(len(model.std)), atol=1e-9)
    for part in (model.outer, model.inner):
        flat = part.modes.reshape(len(part.modes), -1)
        assert np.allclose(flat @ flat.T, np.eye(len(flat)), atol=1e-4)
    assert (np.diff(model.std) <= 0).all()


def test_the_weight_makes_shape_and_pixels_vary_alike(model: AppearanceModel) -> None:
    pixels = (model.outer.std**2).sum() + (model.inner.std**2).sum()
    assert model.weight**2 * (model.face.std**2).sum() == pytest.approx(pixels)


def test_textures_are_of_single_precision(model: AppearanceModel) -> None:
    outer, inner = np.zeros((2, len(model.outer.std))), np.zeros((2, len(model.inner.std)))
    assert model.textures(outer, inner).dtype == np.float32


def test_a_model_is_saved_in_a_new_folder_of_a_new_folder(model: AppearanceModel, tmp_path: Path) -> None:
    save_appearance(model, tmp_path / "a" / "b", {})
    assert load_appearance(tmp_path / "a" / "b").weight == pytest.approx(model.weight)


def test_the_two_regions_share_no_pixel_and_leave_none(model: AppearanceModel) -> None:
    both = np.sort(np.concatenate([model.outer.place, model.inner.place]))
    assert both.tolist() == list(range(len(model.mesh.pixels)))


def test_the_inner_region_lies_between_the_lips(model: AppearanceModel) -> None:
    row, column = np.divmod(model.mesh.pixels[model.inner.place], model.mesh.width)
    lips = model.mesh.reference[np.searchsorted(model.rows, model.face.rows(INNER_LIPS))]
    assert lips[:, 0].min() <= column.min() < column.max() <= lips[:, 0].max()
    assert lips[:, 1].min() <= row.min() < row.max() <= lips[:, 1].max()
    assert inner_mouth(model.face, model.rows, model.mesh).sum() == len(model.inner.place)


def test_the_light_of_a_clip_is_taken_out(model: AppearanceModel) -> None:
    modes, textures = model.instance(some_joint(model, 12))
    light = np.linspace(-20, 30, textures[0].size).reshape(textures[0].shape)
    plain, lit = model.without_light(textures, modes), model.without_light(textures + light, modes)
    assert np.allclose(plain, lit, atol=1e-2)
    moved = plain - plain.mean(axis=0) - (textures - textures.mean(axis=0))
    assert np.abs(moved).max() < 1e-2  # what happens within the clip stays


def test_pixel_mse_is_in_grey_levels_squared(model: AppearanceModel) -> None:
    joint = some_joint(model)
    grey = model.instance(joint)[1] @ LUMA
    assert pixel_mse(model, joint, grey).whole.max() < 1e-6
    off = grey.copy()
    off[:, model.inner.place] += 3
    error = pixel_mse(model, joint, off)
    assert np.allclose(error.inner, 9, atol=1e-2)
    assert np.allclose(error.outer, 0, atol=1e-4)
    assert np.allclose(error.whole, 9 * len(model.inner.place) / grey.shape[1], atol=1e-2)


def test_renderings_are_pictures_of_even_size(model: AppearanceModel) -> None:
    pictures = model.render(some_joint(model, 2), scale=1.5)
    assert pictures.dtype == np.uint8
    assert pictures.shape[0] == 2
    assert not pictures.shape[1] % 2
    assert not pictures.shape[2] % 2
    assert len(np.unique(pictures)) > 50


def test_principal_directions_of_wide_and_tall_samples_agree() -> None:
    rng = np.random.default_rng(2)
    samples = rng.normal(size=(30, 4)) @ rng.normal(size=(4, 12))
    tall, wide = principal(samples, 0.9999), principal(np.hstack([samples, np.zeros((30, 40))]), 0.9999)
    assert len(tall[1]) == 4
    assert np.allclose(tall[1], wide[1])
    assert np.allclose(tall[0], wide[0][:, :12], atol=1e-9)


def test_a_saved_model_is_the_same_model(model: AppearanceModel, tmp_path: Path) -> None:
    save_appearance(model, tmp_path / "one", {"bound": 1})
    again = load_appearance(tmp_path / "one")
    save_appearance(again, tmp_path / "two", {"bound": 1})
    for name in ("appearance.json", "appearance.safetensors"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    joint = some_joint(model, 1)
    assert np.array_equal(again.render(joint), model.render(joint))


def test_a_folder_without_a_model(tmp_path: Path) -> None:
    with pytest.raises(
        ModelError, match=r"is not an appearance model .*make one with `phonanim corpus appearance`"
    ):
        load_appearance(tmp_path)


def test_a_model_of_another_format(model: AppearanceModel, tmp_path: Path) -> None:
    save_appearance(model, tmp_path, {"format": 99})
    with pytest.raises(ModelError, match=r"format 99, not 1"):
        load_appearance(tmp_path)


def test_shapes_that_do_not_agree(model: AppearanceModel, tmp_path: Path) -> None:
    save_appearance(replace(model, basis=model.basis[:, :-1]), tmp_path, {})
    with pytest.raises(ModelError, match="is not an appearance model .*shapes do not match"):
        load_appearance(tmp_path)


def test_a_larger_picture_shows_the_same_mouth(model: AppearanceModel) -> None:
    """The mouth lies in the middle of the picture, at any scale."""
    joint = np.zeros((1, some_joint(model, 1).shape[1]))
    middles = []
    for scale in (1.0, 2.0, 3.0):
        (picture,) = model.render(joint, scale)
        drawn = np.argwhere((picture != BACKDROP).any(axis=2))
        middles.append(drawn.mean(axis=0) / scale)
        assert len(drawn) / scale**2 == pytest.approx(len(model.mesh.pixels), rel=0.1)
        assert np.abs(drawn.mean(axis=0) / picture.shape[:2] - 0.5).max() < 0.1
    assert np.ptp(middles, axis=0).max() < 1.5
