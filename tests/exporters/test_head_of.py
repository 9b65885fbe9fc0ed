"""Films and stages of characters: which meshes, where they stand, and what they look like."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from animations import line, only

from phonanim.exporters import save
from phonanim.exporters._head import load_drawable_head
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.character import GREY
from phonanim.rig.head import SHIPPED, load_dressed_head, load_head
from phonanim.rig.meshes import write_head
from phonanim.rig.render import render, whole_head


@pytest.fixture
def bare(tmp_path):
    """The shipped head without materials and with names of its own for the parts."""
    write_head(tmp_path / "hero.glb", load_head())
    return tmp_path / "hero.glb"


def test_the_shipped_head_is_itself():
    assert load_drawable_head(SHIPPED) is load_dressed_head()


def test_a_head_of_the_same_shape_in_grey(bare):
    head = load_drawable_head(bare)
    np.testing.assert_allclose(head.vertices, load_head().vertices, atol=1e-6)
    np.testing.assert_array_equal(head.colors, GREY)


def test_colours_of_materials_and_vertices_stay(tmp_path):
    glb = read_glb(SHIPPED)
    path = tmp_path / "mine.glb"
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    np.testing.assert_allclose(load_drawable_head(path).colors, load_head().colors)
    tree = copy.deepcopy(glb.tree)
    for material in tree["materials"]:
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    path.write_bytes(glb_bytes(tree, glb.binary))
    np.testing.assert_array_equal(load_drawable_head(path).colors, GREY)


def test_the_view_is_of_the_face_when_parts_have_other_names(bare):
    head = load_drawable_head(bare)
    picture = render(head.vertices, head, whole_head(head, 64, 64))
    shipped = whole_head(load_head(), 64, 64)
    view = whole_head(head, 64, 64)
    assert view.span == pytest.approx(shipped.span, rel=0.5)
    assert np.abs(picture.astype(int) - picture[0, 0]).max() > 50


def test_a_film_of_it(bare, tmp_path):
    pytest.importorskip("av", reason="needs the extra video")
    save(only(line(frames=3), jawOpen=0.5), tmp_path / "a.mp4", character=bare, size=64)
    assert (tmp_path / "a.mp4").stat().st_size > 500
