"""`phonanim rig`: a character of one's own, from its file to its animation."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.errors import MissingExtraError, RigError
from phonanim.face.model import INNER_LIP_PAIRS, MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.align import add_viseme_shapes
from phonanim.rig.character import load_character
from phonanim.rig.fit_character import fit_character, speech_controls
from phonanim.rig.fit_quality import fit_quality
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmark_rig import make_landmark_rig
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.meshes import write_head
from phonanim.rig.register import suggest_landmarks
from phonanim.rig.rims import put_on_rims

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # y up to z up


def vrm_head() -> Head:
    """The shipped head with VRM's expressions for shapes, in centimetres, z up."""
    full = add_viseme_shapes(load_head())
    rows = [full.targets.index(name) for name in ("aa", "ih", "ou", "ee", "oh", "blinkLeft", "blinkRight")]
    return replace(
        full,
        targets=tuple(full.targets[row] for row in rows),
        deltas=full.deltas[rows] @ UPRIGHT * 100,
        vertices=full.vertices @ UPRIGHT * 100,
    )


def unsided(head: Head) -> Head:
    """ARKit's names as other programs write them."""
    names = [name.replace("Left", "_L").replace("Right", "_R") for name in head.targets]
    return replace(head, targets=tuple(f"Face.{name}" for name in names))


@pytest.fixture(scope="module")
def vrm_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("character") / "hero.glb"
    write_head(path, vrm_head())
    return path


# Files.


def test_a_head_is_read_as_written(tmp_path: Path) -> None:
    head = load_head()
    write_head(tmp_path / "a.glb", head)
    again = load_character(tmp_path / "a.glb")
    assert again.targets == head.targets
    np.testing.assert_allclose(again.vertices, head.vertices, atol=1e-6)
    np.testing.assert_allclose(again.deltas, head.deltas, atol=2e-7)
    np.testing.assert_array_equal(again.triangles, head.triangles)
    assert [part.split(".")[1] for part in again.parts] == list(head.parts)


def test_the_same_head_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_head(tmp_path / f"{name}.glb", vrm_head())
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_the_shipped_file_is_a_character() -> None:
    arkit, head = load_rig("arkit"), load_head()
    again = load_character(arkit.head)
    np.testing.assert_allclose(again.vertices, head.vertices, atol=1e-6)


def test_positions_that_are_not_finite(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    write_head(path, vrm_head())
    data = bytearray(path.read_bytes())
    first = data.index(b"BIN\x00") + 4
    data[first : first + 4] = np.array([np.nan], "<f4").tobytes()
    path.write_bytes(bytes(data))
    with pytest.raises(RigError, match="holds positions that are not finite"):
        load_character(path)


def test_nodes_are_placed_in_the_world(tmp_path: Path) -> None:
    from phonanim.media.glb import glb_bytes, read_glb

    path = tmp_path / "a.glb"
    write_head(path, vrm_head())
    glb = read_glb(path)
    glb.tree["nodes"] = [
        {"name": "head", "mesh": 0, "scale": [2.0, 2.0, 2.0]},
        {"children": [0], "translation": [0.0, 1.0, 0.0], "rotation": [0.0, 0.0, 0.7071068, 0.7071068]},
    ]
    path.write_bytes(glb_bytes(glb.tree, glb.binary))
    x, y, z = vrm_head().vertices.T * 2
    np.testing.assert_allclose(load_character(path).vertices, np.column_stack([-y, x + 1, z]), atol=1e-3)


# Finding the face.


def test_landmarks_are_found_on_the_head_that_they_came_from() -> None:
    head, spots = load_head(), shipped_landmarks()
    found = suggest_landmarks(head, spots, unsided(head))
    apart = np.linalg.norm(found.of(head.vertices) - spots.of(head.vertices), axis=1) * 1000
    lips = [number for pair in INNER_LIP_PAIRS for number in pair]
    assert np.median(apart) < 1.0
    assert apart[[*lips, MOUTH_CORNER_LEFT, MOUTH_CORNER_RIGHT]].max() < 2.5  # mm


def test_rims_part_the_lips() -> None:
    head, spots = load_head(), shipped_landmarks()
    skin = head.triangles[(head.triangles < head.parts["skin"].stop).all(axis=1)]
    swapped = spots.corners.copy()
    swapped[13], swapped[14] = spots.corners[14], spots.corners[13]
    again = put_on_rims(head.vertices, skin, replace(spots, corners=swapped))
    height = again.of(head.vertices)[:, 1]
    assert all(height[upper] >= height[lower] for upper, lower in INNER_LIP_PAIRS)


def test_a_vrm_head_in_other_axes_and_units_is_fitted() -> None:
    face, head = load_model("default").face, vrm_head()
    rig, spots = fit_character(head, face, "hero")
    assert rig.speech == ("aa", "ih", "ou", "ee", "oh")
    found = fit_quality(rig, head, spots, face)
    assert found.measures["lip_gap"].slope > 0.85
    assert found.measures["lip_gap"].r > 0.95
    assert found.measures["lip_width"].slope > 0.5
    assert found.open_at_closures < 0.5
    assert rig.poses.shape == (8, 7)


def test_the_reference_head_of_another_make(shared_data: Path) -> None:
    face = load_model("default").face
    rig, spots = fit_character(ict_head(shared_data), face, "ict")
    found = fit_quality(rig, ict_head(shared_data), spots, face)
    assert found.measures["lip_gap"].slope > 0.9
    assert found.measures["lip_width"].slope > 0.8
    assert found.measures["protrusion"].slope > 0.8
    assert found.measures["jaw"].slope > 0.9
    assert found.open_at_closures < 0.5
    assert found.short == ()


def ict_head(shared_data: Path) -> Head:
    """ICT-FaceKit's head: other topology, centimetres, quads."""
    with np.load(shared_data / "rigs" / "ict_head.npz") as stored:
        quads = stored["quads"].astype(np.int64)
        whole = quads[:, 3] < len(stored["V"])
        parts = dict(
            zip(stored["part_names"].tolist(), (slice(*p) for p in stored["parts"].tolist()), strict=True)
        )
        deltas = stored["delta_i16"] * float(stored["delta_scale"])
        vertices = stored["V"].astype(np.float64)
        names = tuple(stored["names"].tolist())
    triangles = np.concatenate([quads[:, :3], quads[whole][:, [0, 2, 3]]])
    return Head(vertices, triangles, parts, names, deltas, np.full_like(vertices, 0.3))


def test_a_head_without_known_names_is_said() -> None:
    head = load_head()
    strange = replace(head, targets=tuple(f"shape{i}" for i in range(len(head.targets))))
    with pytest.raises(
        RigError, match="0 shapes whose names are known, too few .* or mark it: phonanim rig land"
    ):
        suggest_landmarks(head, shipped_landmarks(), strange)


def test_shapes_without_known_names_are_judged_by_what_they_move() -> None:
    face, head = load_model("default").face, load_head()
    strange = replace(head, targets=tuple(f"shape{i}" for i in range(len(head.targets))))
    chosen = speech_controls(make_landmark_rig(strange, shipped_landmarks(), face), face, load_rig("arkit"))
    names = {head.targets[int(name.removeprefix("shape"))] for name in chosen}
    assert {"jawOpen", "mouthPucker", "mouthClose", "mouthLowerDownLeft", "mouthSmileRight"} <= names
    assert not {"jawLeft", "mouthRight", "eyeBlinkLeft", "browInnerUp"} & names


def test_a_head_whose_lips_do_not_move_is_said() -> None:
    face, head = load_model("default").face, load_head()
    blink = head.targets.index("eyeBlinkLeft")
    still = replace(head, targets=("wink",), deltas=head.deltas[[blink]])
    with pytest.raises(RigError, match="no shape of the head moves its lips"):
        fit_character(still, face, "still", shipped_landmarks())


def test_scipy_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "scipy", None)
    with pytest.raises(MissingExtraError, match=r"fitting a rig needs scipy: pip install 'phonanim\[rig\]'"):
        suggest_landmarks(load_head(), shipped_landmarks(), load_head())


# The command.


def test_fit_check_and_animate(vrm_file: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    toml, sheet = vrm_file.with_suffix(".toml"), vrm_file.with_suffix(".png")
    assert run(["rig", "fit", str(vrm_file), "--contact-sheet", str(sheet), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["rig"] == str(toml)
    assert facts["measures"]["lip_gap"]["slope"] > 0.85
    assert facts["short"] == []
    assert facts["reach"]["protrusion"] > 0.8
    assert sheet.read_bytes().startswith(b"\x89PNG")
    assert run(["rig", "check", str(toml)]) == 0
    assert "good, 7 controls" in capsys.readouterr().out
    curves = vrm_file.with_suffix(".npz")
    assert (
        run(
            ["animate", str(root / "examples" / "line.TextGrid"), "-o", str(curves), "--rig", str(toml), "-q"]
        )
        == 0
    )
    mended = ["rig", "fit", str(vrm_file), "--landmarks", str(vrm_file.with_suffix(".landmarks.csv")), "-q"]
    before = load_rig(str(toml)).poses
    toml.unlink()
    assert run(mended) == 0
    np.testing.assert_allclose(load_rig(str(toml)).poses, before, atol=0.02)  # the table is rounded


def test_new_writes_poses_and_a_file_to_fill_in(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "hero"
    assert run(["rig", "new", str(folder)]) == 0
    written = {path.name for path in folder.iterdir()}
    assert {"hero.toml", "poses.png", "poses.glb", "mode1_plus.obj", "mean.obj"} <= written
    assert len(written) == 12
    capsys.readouterr()
    assert run(["rig", "check", str(folder / "hero.toml")]) == 2
    told = capsys.readouterr().out
    assert "[poses.mode1_plus] is missing: mouth wide open" in told
    assert run(["rig", "new", str(folder)]) == 2
    assert "already exists; choose another name" in capsys.readouterr().err


def test_new_from_a_head_names_its_controls(vrm_file: Path, tmp_path: Path) -> None:
    assert run(["rig", "new", str(tmp_path / "hero"), "--head", str(vrm_file), "-q"]) == 0
    text = (tmp_path / "hero" / "hero.toml").read_text(encoding="utf-8")
    assert "aa = [0.0, 0.0, 1.0]" in text


def test_a_filled_in_rig_animates(tmp_path: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rig", "new", str(tmp_path / "hero"), "-q"]) == 0
    path = tmp_path / "hero" / "hero.toml"
    text = path.read_text(encoding="utf-8").replace("# [poses", "[poses").replace("# jaw", "jaw")
    path.write_text(text.replace("jaw = 0.0", "jaw = 0.4", 3), encoding="utf-8")
    capsys.readouterr()
    assert run(["rig", "check", str(path)]) == 0
    told = capsys.readouterr().out
    assert "[poses.mode2_plus] is the same as [poses.mode2_minus]; is it filled in?" in told
    assert "no pose moves lips_round, lips_wide" in told
    out = tmp_path / "a.json"
    assert (
        run(["animate", str(root / "examples" / "line.TextGrid"), "-o", str(out), "--rig", str(path), "-q"])
        == 0
    )


def test_a_rig_without_a_head_cannot_be_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        "[controls]\njaw = [0.0, 0.0, 1.0]\n[poses.mean]\n"
        + "".join(
            f"[poses.mode{k}_{side}]\njaw = 0.{k}\n" for k in range(1, 5) for side in ("minus", "plus")
        ),
        encoding="utf-8",
    )
    assert run(["rig", "check", str(path), "--contact-sheet", str(tmp_path / "a.png")]) == 2
    assert "names no head and landmarks to draw" in capsys.readouterr().err


def test_list_names_every_rig(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rig", "list", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert {"arkit", "metahuman", "vrm"} <= {entry["name"] for entry in facts}
