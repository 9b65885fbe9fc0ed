"""Tables on PHONANIM_PATH: languages, rigs, poses and models of one's own, by name."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from phonanim.animation.overlay import find_overlay, is_pose
from phonanim.core.catalog import find_model, list_models
from phonanim.core.lexicon import LEXICON, find_tables
from phonanim.errors import LabelError
from phonanim.rig import load_rig, rig_names
from phonanim.speech import labels
from phonanim.speech.labels import language_names, load_language

GOOD = 'title = "Mine"\ncode = "qq"\n[phones]\n"x" = "b aa"\n'


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on PHONANIM_PATH, after one that does not exist."""
    monkeypatch.setenv("PHONANIM_PATH", f"{tmp_path / 'absent'}{os.pathsep}{tmp_path}")
    for kind in ("languages", "rigs", "poses", "models"):
        (tmp_path / kind).mkdir()
    yield tmp_path
    load_language.cache_clear()
    labels._read_language.cache_clear()


def test_a_language_is_found_after_the_shipped_ones(own: Path) -> None:
    (own / "languages/aaa.toml").write_text(GOOD)
    assert language_names()[-1] == "aaa"
    assert load_language("qq").title == "Mine"
    assert load_language("aaa").resolve("x") == labels.Sound(tuple(labels.INVENTORY.codes(["b", "aa"])))


def test_a_shipped_name_wins(own: Path) -> None:
    (own / "languages/german.toml").write_text(GOOD)
    assert find_tables("languages")["german"] == LEXICON / "languages/german.toml"
    assert load_language("german").code == "de"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("title = ", "it is not TOML: Invalid value"),
        ('code = "qq"', "has no 'title'"),
        (GOOD.replace("aa", "qqq"), "'qqq' is not one of the phones sil "),
        (
            GOOD.replace("[phones]", "[closures]").replace("b aa", "b zz"),
            "'zz' is not one of the phones sil ",
        ),
        (GOOD.replace("[phones]", "[ipa]").replace("b aa", "%"), "not IPA: %"),
        ('alphabets = ["Runes"]\n' + GOOD, "'Runes' is not one of the alphabets IPA, SAMPA"),
        ('phones = "b"\ntitle = "Mine"\ncode = "qq"', "'str' object has no attribute 'items'"),
    ],
)
def test_a_file_that_is_no_language_is_named(own: Path, text: str, fault: str) -> None:
    path = own / "languages/aaa.toml"
    path.write_text(text)
    with pytest.raises(LabelError) as error:
        load_language("aaa")
    assert str(error.value).startswith(f"{path}: is not a valid language: {fault}")
    assert str(error.value).endswith("; docs/languages.md describes the file")


def test_a_rig_is_found_with_the_files_beside_it(own: Path) -> None:
    for path in (LEXICON / "rigs").glob("vrm*"):
        shutil.copy(path, own / "rigs" / path.name.replace("vrm.toml", "mine.toml"))
    text = (own / "rigs/mine.toml").read_text("utf-8")
    (own / "rigs/mine.toml").write_text(text.replace('name = "vrm"', 'name = "mine"'), "utf-8")
    assert rig_names()[-1] == "mine"
    assert load_rig("mine").controls == load_rig("vrm").controls


def test_a_pose_is_found(own: Path) -> None:
    shutil.copy(LEXICON / "poses/smile.toml", own / "poses/grin.toml")
    assert is_pose("grin")
    assert find_overlay("grin") == own / "poses/grin.toml"


def test_a_model_is_found(own: Path) -> None:
    shutil.copytree(find_model("default"), own / "models/mine")
    assert find_model("mine") == own / "models/mine"
    assert "mine" in [entry.name for entry in list_models()]
