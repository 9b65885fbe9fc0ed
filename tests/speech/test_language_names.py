"""A language is found by its codes and by its English and native names."""

from __future__ import annotations

from pathlib import Path

import pytest

from phonanim.errors import LabelError
from phonanim.speech.language_files import load_language
from phonanim.speech.language_names import find_language, language_names, language_weights


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("jpn", "japanese"),
        ("ja-JP", "japanese"),
        ("日本語", "japanese"),
        ("German", "german"),
        ("DEUTSCH", "german"),
        ("de_CH", "german"),
        ("ger", "german"),
        ("Français", "french"),
        ("francais", "french"),
        ("fr-CA", "french"),
        ("cmn-Hans-CN", "mandarin"),
        ("zh-yue", "cantonese"),
        ("zh_HK", "cantonese"),
        ("zh-Hant-HK", "cantonese"),
        ("zh-Hant-TW", "mandarin"),
        ("sr-Latn-RS", "croatian"),
        ("yue", "cantonese"),
        ("nb", "norwegian"),
        ("nno", "norwegian"),
        ("Brazilian Portuguese", "portuguese"),
        ("vietnamese_hanoi_mfa", "vietnamese"),
        ("Tiếng Việt", "vietnamese"),
        ("ไทย", "thai"),
        ("iw", "hebrew"),
        ("Kiswahili", "swahili"),
        ("sr-Latn", "croatian"),
        ("urd", "hindi"),
        ("french_prosodylab", "french_prosodylab"),
    ],
)
def test_codes_and_names(name: str, stem: str) -> None:
    assert load_language(name).name == stem


@pytest.mark.parametrize("name", ["", "zz", "xx-YY", "klingon", "../german", "a" * 5000])
def test_what_is_no_language_is_refused(name: str) -> None:
    assert find_language(name) is None
    with pytest.raises(LabelError, match="there is no language"):
        load_language(name)


def test_every_language_with_a_code_has_names_and_a_weight() -> None:
    for name in language_names():
        language = load_language(name)
        if language.code:
            assert find_language(language.code) == name
            assert language_weights()[name] > 0


def test_a_language_of_the_user_goes_by_its_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "languages"
    folder.mkdir()
    (folder / "klingon.toml").write_text('title = "Klingon"\ncode = "tlh"\n[phones]\nH = "k"\n', "utf-8")
    monkeypatch.setenv("PHONANIM_PATH", str(tmp_path))
    assert load_language("tlh").name == "klingon"
