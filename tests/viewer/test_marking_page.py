"""The page on which a face is marked: what it holds, and marked in a browser."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conventions import write_convention

from phonanim.core.lexicon import LEXICON
from phonanim.media.glb import parse_glb
from phonanim.rig.character import load_character
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.viewer.marking_page import write_marking_page

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


def data_of(page):
    found = re.search(r'<script id="data"[^>]*>(.*?)</script>', page.read_text("utf-8"), re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def test_the_page_holds_the_head_row_by_row(tmp_path):
    """Rows of the saved table are those of the character as `rig fit` reads it."""
    hero = write_convention("BS_", tmp_path / "hero.glb")
    write_marking_page(hero, tmp_path / "a.html")
    data, head = data_of(tmp_path / "a.html"), load_character(hero)
    glb = parse_glb(base64.b64decode(data["head"]), "page")
    primitives = glb.tree["meshes"][0]["primitives"]
    for first, primitive in zip(data["first"], primitives, strict=True):
        points = glb.positions(primitive["attributes"]["POSITION"])
        np.testing.assert_allclose(points, head.vertices[first : first + len(points)], atol=1e-6)
        assert {"NORMAL", "COLOR_0"} <= set(primitive["attributes"])
    assert glb.tree["meshes"][0]["extras"]["targetNames"][0] == "BS_jawOpen"
    assert data["command"] == "phonanim rig fit hero.glb --landmarks hero.points.csv"
    assert data["marked"] == []


def test_points_that_are_known_are_there_to_correct(tmp_path):
    hero = write_convention("BS_", tmp_path / "hero.glb")
    write_marking_page(hero, tmp_path / "a.html", shipped_landmarks())
    marked = {point["landmark"]: point for point in data_of(tmp_path / "a.html")["marked"]}
    assert len(marked) == 15
    one = shipped_landmarks().take([61])
    assert marked[61]["corners"] == one.corners[0].tolist()


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium or google-chrome")
def test_a_person_marks_a_face(tmp_path, root):
    head, table = LEXICON / "rigs" / "head.glb", LEXICON / "rigs" / "arkit.landmarks.csv"
    script = [sys.executable, str(root / "scripts" / "check_landmarks.py")]
    done = subprocess.run(
        [*script, str(head), str(table), "-o", str(tmp_path)], capture_output=True, text=True, timeout=500
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("15 points") == 2
