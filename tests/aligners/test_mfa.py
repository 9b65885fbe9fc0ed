"""`phonanim align --aligner mfa` with a small program in the place of the Montreal Forced Aligner."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from textgrid_text import long_text

from phonanim.__main__ import run
from phonanim.aligners.mfa import align
from phonanim.errors import AlignmentError, MissingExtraError, OptionError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Interval

WORDS = [("0", "0.5", ""), ("0.5", "1.0", "guten"), ("1.0", "1.5", "tag"), ("1.5", "4.52", "")]
PHONES = [
    *(("0", "0.5", ""), ("0.5", "0.7", "ɡ"), ("0.7", "1.0", "uː")),
    *(("1.0", "1.2", "t"), ("1.2", "1.5", "aː"), ("1.5", "4.52", "sil")),
]

Fake = Callable[..., Path]


@pytest.fixture
def fake(tmp_path: Path, root: Path, monkeypatch: pytest.MonkeyPatch) -> Fake:
    """An executable mfa that notes how it was called, prints, writes a TextGrid and exits."""
    shutil.copy(root / "examples/line.wav", tmp_path / "line.wav")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.chdir(tmp_path)

    def make(phones: list = PHONES, words: list = WORDS, grid: str | None = None, end: str = "") -> Path:
        written = (
            long_text([("words", words), ("phones", phones)], end=float(phones[-1][1]))
            if grid is None
            else grid
        )
        program = tmp_path / "mfa"
        program.write_text(
            f"#!{sys.executable}\n"
            "import json, pathlib, sys\n"
            "said = pathlib.Path(sys.argv[4]).read_text('utf-8')\n"
            f"pathlib.Path({str(tmp_path / 'call.json')!r}).write_text(json.dumps([sys.argv[1:], said]))\n"
            f"{end}\n"
            f"pathlib.Path(sys.argv[7]).write_text({written!r}, 'utf-8')\n",
            "utf-8",
        )
        program.chmod(0o755)
        return tmp_path / "line.wav"

    return make


def test_words_and_phones_become_a_textgrid(
    fake: Fake, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    line = fake()
    options = ["--aligner", "mfa", "--mfa-model", "german_mfa"]
    assert run(["align", "line.wav", "--text", "Guten\n Tag!", "-o", "a.TextGrid", *options]) == 0
    assert "found 2 words, 4 phones" in capsys.readouterr().err
    alignment = read_alignment(tmp_path / "a.TextGrid")
    assert [phone.label for phone in alignment.intervals] == ["", "ɡ", "uː", "t", "aː", ""]
    assert alignment.words[1] == Interval("guten", 0.5, 1.0)
    arguments, said = json.loads((tmp_path / "call.json").read_text())
    assert arguments[:3] == ["align_one", "--clean", str(line)]
    assert arguments[4:6] == ["german_mfa", "german_mfa"]
    assert said == "Guten Tag!\n"
    assert not Path(arguments[6]).parent.exists()


def test_a_dictionary_of_its_own(fake: Fake, tmp_path: Path) -> None:
    align(fake(), "guten tag", "german_mfa", "my.dict")
    arguments, _ = json.loads((tmp_path / "call.json").read_text())
    assert arguments[4:6] == ["my.dict", "german_mfa"]


def test_failure_is_its_last_line(fake: Fake, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    said = "working ...\n\x1b[31m╭─ Error ──╮\x1b[0m\n│ no dictionary 'german_mfa' │\n╰──────────╯\n"
    fake(end=f"print({said!r}, file=sys.stderr); sys.exit(3)")
    assert run(["align", "line.wav", "--text", "guten tag", "--aligner", "mfa"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "line.wav: the Montreal Forced Aligner failed: no dictionary 'german_mfa'\n" in error
    assert not (tmp_path / "line.TextGrid").exists()


def test_failure_without_a_word(fake: Fake) -> None:
    line = fake(end="sys.exit(3)")
    with pytest.raises(AlignmentError, match=r"line.wav: the Montreal Forced Aligner failed: exit code 3"):
        align(line, "guten tag")


DAMAGED = [
    ({"end": "sys.exit(0)"}, r"line.wav: the Montreal Forced Aligner wrote no TextGrid; run it by hand"),
    (
        {"grid": "oops"},
        r"line.wav: the output of the Montreal Forced Aligner is not an alignment in a known format",
    ),
    (
        {"phones": [("0", "1.0", "t")]},
        r"lasts 4.52 s, but the output of the Montreal Forced Aligner lasts 1.00 s",
    ),
    ({"phones": [("0", "4.52", "sil")]}, r"the Montreal Forced Aligner found no phone; check that the text"),
    (
        {"phones": [("0", "0.5", "t"), ("0.5", "1.0", "spn"), ("1.0", "4.52", "")]},
        r"the word 'guten' at 0.50 s is not in the dictionary; add it to a dictionary of your own",
    ),
]


@pytest.mark.parametrize(("changes", "message"), DAMAGED)
def test_what_it_writes_is_checked(changes: dict, message: str, fake: Fake) -> None:
    line = fake(**changes)
    with pytest.raises(AlignmentError, match=message):
        align(line, "guten tag")


def test_it_is_not_installed(fake: Fake, tmp_path: Path) -> None:
    line = fake()
    (tmp_path / "mfa").unlink()
    with pytest.raises(MissingExtraError, match=r"needs the Montreal Forced Aligner: conda install .* PATH"):
        align(line, "guten tag")


@pytest.mark.parametrize("text", [None, "...", ""])
def test_it_needs_a_text(text: str | None, fake: Fake) -> None:
    with pytest.raises(OptionError, match=r"needs the spoken words; give them with --text or --text-file"):
        align(fake(), text)


def test_its_options_without_it(fake: Fake, capsys: pytest.CaptureFixture) -> None:
    fake()
    assert run(["align", "line.wav", "--text", "tag", "--mfa-model", "german_mfa"]) == 2
    assert "--mfa-model and --mfa-dictionary are for --aligner mfa; add it" in capsys.readouterr().err
