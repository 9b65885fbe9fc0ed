"""The shipped head under the names of conventions is found, moves, and closes its lips as by its own."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conventions import MAKERS, STYLES, write_convention

from phonanim.__main__ import run
from phonanim.errors import RigError
from phonanim.media.glb import Glb, read_glb
from phonanim.options import Options
from phonanim.pipeline import animate_detailed
from phonanim.rig.align import align_heads, check_alignment
from phonanim.rig.character import load_character
from phonanim.rig.coverage import choose_rig, coverage_notes
from phonanim.rig.head import SHIPPED, TONGUE, Head, load_head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.measures import MEASURES
from phonanim.rig.measuring import mouth_effects
from phonanim.rig.meshes import write_head
from phonanim.rig.morphs import find_morphs
from phonanim.speech.inventory import INVENTORY

CLOSED, OPEN, NARROWER = 1.5, 8.0, 0.6  # mm, mm, share of the shipped head's


def mouth(head: Head, rig: str, line: Path) -> dict[str, float]:
    """The lips of a head in a line: the widest gap of p b m and of open vowels; the widest i less u."""
    made = animate_detailed(line, Options(rig=rig, life=0.0))
    placed = to_face_axes(head, shipped_landmarks(), made.face)
    effects, rest = mouth_effects(placed, shipped_landmarks())
    shown = rest + placed.weights(made.animation.values, made.animation.channels) @ effects
    gap, width = shown[:, MEASURES.index("gap")], shown[:, MEASURES.index("width")]
    frames = np.searchsorted(made.animation.times, made.track.bounds)
    gaps: dict[str, list[float]] = {"closed": [], "open": []}
    widths: dict[str, list[float]] = {"iy": [], "uw": []}
    for code, (first, last) in zip(made.track.codes, itertools.pairwise(frames), strict=True):
        phone = INVENTORY.phones[code]
        if phone in ("p", "b", "m"):
            gaps["closed"].append(gap[first:last].min())
        if phone in ("aa", "ae", "ao"):
            gaps["open"].append(gap[first:last].max())
        if phone in widths:
            widths[phone].append(width[first:last].max() if phone == "iy" else width[first:last].min())
    narrower = np.mean(widths["iy"]) - np.mean(widths["uw"])
    return {"closed": max(gaps["closed"]), "open": max(gaps["open"]), "narrower": float(narrower)}


def check(name: str, folder: Path, line: Path) -> None:
    character = write_convention(name, folder / "hero.glb")
    rig, _ = choose_rig(character)
    found = mouth(load_character(character), rig, line)
    shipped = mouth(load_head(), "arkit", line)
    assert found["closed"] <= CLOSED
    assert found["open"] >= OPEN
    if name != "Ready Player Me":  # its two shapes do not round the lips
        assert found["narrower"] >= NARROWER * shipped["narrower"]


def test_parts_of_shapes_move_the_mouth(tmp_path, root):
    check("Reallusion", tmp_path, root / "examples" / "line.TextGrid")


def fitted(head: Head, folder: Path, line: Path) -> dict[str, float]:
    """The lips of a head with the rig that is fitted to it, measured at the points where they are."""
    write_head(folder / "hero.glb", head)
    assert run(["rig", "fit", str(folder / "hero.glb"), "--json"]) == 0
    return mouth(load_character(folder / "hero.glb"), str(folder / "hero.toml"), line)


def test_a_doubtful_face_asks_for_landmarks():
    head = MAKERS["VRoid"]()
    mixed = replace(head, targets=tuple(np.roll(head.targets, 3).tolist()))
    with pytest.raises(RigError, match=r"not sure where the face is: its shapes lie \d+ mm .*--landmarks"):
        align_heads(load_head(), mixed)
    behind = np.array([0.0, 0.0, 0.1])
    goal = np.zeros((4, 3))
    hair = np.random.default_rng(0).uniform([-0.1, -0.1, 0.0], [0.1, 0.1, 0.2], (500, 3))
    with pytest.raises(RigError, match=r"most of the head is in front .*--landmarks"):
        check_alignment(goal, goal, hair)
    check_alignment(goal, goal, hair - 2 * behind)


@pytest.mark.slow
@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", ["arkit", "VRoid", "VRChat"])
def test_rigs_are_fitted_to_stylized_heads(name, style, tmp_path, root):
    head = load_head().without(TONGUE) if name == "arkit" else MAKERS[name]()
    found = fitted(STYLES[style](head), tmp_path, root / "examples" / "line.TextGrid")
    shipped = mouth(load_head(), "arkit", root / "examples" / "line.TextGrid")
    assert found["closed"] <= CLOSED
    assert found["open"] >= OPEN
    assert found["narrower"] >= NARROWER * shipped["narrower"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in MAKERS if name != "Reallusion"])
def test_every_convention_moves_the_mouth(name, tmp_path, root):
    check(name, tmp_path, root / "examples" / "line.TextGrid")


def test_what_finds_nothing_is_said(tmp_path):
    character = write_convention("Ready Player Me", tmp_path / "hero.glb")
    channels = load_head().targets
    lacking, *others = coverage_notes(character, "arkit", channels)
    assert "hero.glb: 12 of 16 mouth controls have no shape: mouthFunnel, " in lacking
    assert lacking.endswith(" and 4 more")
    assert others == []
    assert coverage_notes(character, "arkit", ("jawOpen",)) == [
        f"{character}: 1 of 2 shapes has no control: mouthSmile"
    ]


def test_empty_shapes_are_left_out(tmp_path):
    head = load_head().without(
        tuple(name for name in load_head().targets if name not in ("jawOpen", "mouthFunnel"))
    )
    head.deltas[0] = 0
    character = tmp_path / "hero.glb"
    write_head(character, head)
    assert load_character(character).targets == ("mouthFunnel",)
    (morphs,) = find_morphs(read_glb(character))
    assert morphs.moved(("jawOpen", "mouthFunnel")) == [(1, 1, 1.0)]
    notes = coverage_notes(character, "arkit", ("jawOpen", "mouthFunnel"))
    assert f"{character}: 1 of 2 shapes moves nothing and is left out: jawOpen" in notes


def test_names_on_accessors():
    targets = [{"POSITION": 0}, {"POSITION": 1}]
    tree = {
        "meshes": [{"primitives": [{"targets": targets}]}],
        "nodes": [{"mesh": 0}],
        "accessors": [{"name": "jawOpen"}, {}],
    }
    (morphs,) = find_morphs(Glb(tree, b"", "a.glb"))
    assert morphs.names == ("jawOpen", "")


def test_the_shipped_head_needs_no_other_rig():
    assert choose_rig(SHIPPED) == ("arkit", "100% of 16 mouth controls")
