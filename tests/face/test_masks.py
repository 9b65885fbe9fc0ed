import json
import runpy

import numpy as np
import pytest
from faces import head_face

from phonanim.errors import EvaluationError
from phonanim.face.masks import (
    check_masks,
    head_masks,
    landmark_masks,
    landmark_numbers,
    parse_masks,
    read_mask,
    read_masks,
)
from phonanim.face.model import INNER_LIPS, OUTER_LIPS
from phonanim.rig.head import load_head


def test_the_red_of_the_lips_is_a_region():
    lips = set(landmark_numbers()["lips"].tolist())
    assert {*INNER_LIPS, *OUTER_LIPS} <= lips
    assert len(lips) == 80  # four rings of twenty
    assert lips < set(landmark_numbers()["mouth"].tolist()) < set(landmark_numbers()["lower"].tolist())
    assert not set(landmark_numbers()["upper"].tolist()) & set(landmark_numbers()["lower"].tolist())


def test_regions_of_the_head_move_with_their_controls():
    head, masks = load_head(), check_masks(head_masks(), len(load_head().vertices))
    for control, region in (("jawOpen", "jaw"), ("mouthPucker", "lips"), ("browInnerUp", "upper")):
        moved = np.linalg.norm(head.deltas[head.targets.index(control)], axis=1)
        assert moved[masks[region]].mean() > 3 * moved.mean()
    assert set(masks["tongue"]) == set(range(head.parts["tongue"].start, head.parts["tongue"].stop))


def test_regions_are_symmetric():
    head, masks = load_head(), head_masks()
    for name in ("lips", "mouth", "jaw", "cheeks", "upper"):
        assert abs(head.vertices[masks[name], 0].mean()) < 0.001


def test_landmark_masks_are_rows_of_a_face():
    face = head_face()
    assert face.indices[landmark_masks(face)["lips"]].tolist() == landmark_numbers()["lips"].tolist()


def test_the_shipped_masks_are_those_that_the_script_makes(root, tmp_path):
    script = root / "scripts" / "build_masks.py"
    before = [(root / "lexicon/masks" / name).read_bytes() for name in ("head.json", "landmarks.json")]
    runpy.run_path(str(script))["main"](tmp_path)
    assert [(tmp_path / name).read_bytes() for name in ("head.json", "landmarks.json")] == before


@pytest.mark.parametrize("text", ["5, 3, 9", "3 5\n9\n", "3;5;9;9"])
def test_lists_as_text(tmp_path, text):
    path = tmp_path / "lips.txt"
    path.write_text(text)
    assert read_mask(path).tolist() == [3, 5, 9]


def test_lists_as_arrays_and_json(tmp_path):
    np.save(tmp_path / "numbers.npy", np.array([2, 1]))
    np.save(tmp_path / "truth.npy", np.array([False, True, True]))
    (tmp_path / "list.json").write_text("[2, 1]")
    assert all(read_mask(path).tolist() == [1, 2] for path in tmp_path.iterdir())


def test_masks_by_region(tmp_path):
    (tmp_path / "all.json").write_text(json.dumps({"source": "me", "lips": [1], "upper": [2, 3]}))
    (tmp_path / "jaw.txt").write_text("4")
    found = parse_masks((str(tmp_path / "all.json"), f"jaw={tmp_path / 'jaw.txt'}"))
    assert {name: rows.tolist() for name, rows in found.items()} == {"lips": [1], "upper": [2, 3], "jaw": [4]}


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("masks.pkl", b"x", "a pickle may run code when it is read"),
        ("words.txt", b"lips", "cannot be read as vertex numbers: invalid literal"),
        ("empty.txt", b"", "is not a list of vertex numbers"),
        ("minus.txt", b"-1 2", "is not a list of vertex numbers"),
        ("half.json", b"[0.5]", "is not a list of vertex numbers"),
        ("torn.json", b"[1", "cannot be read: it is not JSON"),
        ("torn.npy", b"x", "cannot be read: it has no array of numbers"),
        ("none.npy", b"", "cannot be read: it has no array of numbers"),
    ],
)
def test_what_is_no_mask(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(EvaluationError, match=message) as caught:
        read_mask(path)
    assert str(path) in str(caught.value)


def test_a_mask_needs_a_region(tmp_path):
    path = tmp_path / "list.json"
    path.write_text("[1, 2]")
    with pytest.raises(EvaluationError, match="is a list without a name; give it one: --mask lips="):
        parse_masks((str(path),))
    with pytest.raises(EvaluationError, match="--mask lve.txt: name its region, such as lips=lve.txt"):
        parse_masks(("lve.txt",))


def test_a_mask_of_another_mesh():
    with pytest.raises(
        EvaluationError, match="mask lips has vertex 7, but the last vertex is 4; use another"
    ):
        check_masks({"lips": np.array([3, 7])}, 5)


def test_a_region_that_is_no_list_of_numbers_is_named(tmp_path):
    path = tmp_path / "masks.json"
    path.write_text('{"source": "by hand", "lips": [1, 2], "jaw": "wide"}')
    with pytest.raises(EvaluationError, match=r"masks\.json, jaw: "):
        read_masks(path)
