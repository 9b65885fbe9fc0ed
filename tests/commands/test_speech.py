from __future__ import annotations

import json
import wave
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from phonanim.aligners import whisper
from phonanim.commands.animate import command
from phonanim.errors import MissingExtraError, OptionError
from phonanim.inputs.alignment import read_alignment

pytest.importorskip("espeakng_loader", reason="needs the extra espeak")


def run(*arguments: str) -> dict:
    done = CliRunner().invoke(command, [*arguments, "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_text_alone_is_spoken_and_animated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    facts = run("--text", "My mother moved.", "-o", "line.csv", "--rig", "arkit")
    assert facts["alignment"] == "line.TextGrid"
    assert facts["audio"] == "line.wav"
    first = Path("line.csv").read_bytes()
    assert run("--text", "My mother moved.", "-o", "line.csv", "--rig", "arkit") == facts
    assert Path("line.csv").read_bytes() == first


def test_the_language_chooses_the_voice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run("--text", "Tür", "--language", "german", "-o", "a.npz")
    assert '"y' in Path("a.TextGrid").read_text().replace("ˈ", "")


@pytest.mark.parametrize(
    ("voice", "text", "language"),
    [("cmn", "你好，中国人吃饭", "mandarin"), ("ro", "ce mai faci", "romanian"), ("ca", "Bon dia", "ipa")],
)
def test_made_speech_is_read_in_its_language(
    voice: str, text: str, language: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    facts = run("--text", text, "--voice", voice, "-o", "a.npz")
    assert facts["language"]["name"] == language
    assert facts["notes"] == []


def test_other_speech_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("line.wav").write_bytes(b"mine")
    with pytest.raises(OptionError, match=r"line\.wav: already exists, with other speech"):
        run("--text", "My mother.", "-o", "line.csv")
    assert Path("line.wav").read_bytes() == b"mine"
    assert not Path("line.TextGrid").exists()


def test_a_long_recording_is_recognized_once(
    shared_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    pytest.importorskip("pocketsphinx")
    from phonanim.aligners import anchors
    from phonanim.commands.align import command as align_command
    from phonanim.media.audio import read_sound

    sound = read_sound(shared_data / "textgrids" / "002_en_LJ006-0114.wav")
    with wave.open(str(tmp_path / "a.wav"), "wb") as stream:
        stream.setparams((1, 2, sound.rate, 0, "NONE", ""))
        stream.writeframes((np.tile(sound.samples, 6) * 32767).astype("<i2").tobytes())
    windows: list[int] = []
    recognize = anchors.recognize_words
    monkeypatch.setattr(
        anchors, "recognize_words", lambda samples: (windows.append(len(samples)), recognize(samples))[1]
    )
    monkeypatch.setattr("phonanim.aligners.whisper.recognize", lambda *_: pytest.fail("recognized again"))
    done = CliRunner().invoke(align_command, [str(tmp_path / "a.wav"), "--json"], catch_exceptions=False)
    assert sum(windows) == pytest.approx(6 * len(sound.samples) * 16000 / sound.rate, rel=0.01)
    assert json.loads(done.stdout)["words"].count("offices") >= 5


def test_neither_text_nor_alignment() -> None:
    done = CliRunner().invoke(command, [])
    assert done.exit_code == 2
    assert "give an ALIGNMENT, a recording, or --text" in done.output


def test_a_recording_alone_is_understood_and_aligned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared_data: Path
) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    pytest.importorskip("pocketsphinx")
    monkeypatch.chdir(tmp_path)
    Path("b.wav").write_bytes((shared_data / "textgrids" / "002_en_LJ006-0114.wav").read_bytes())
    done = CliRunner().invoke(command, ["b.wav", "-o", "b.csv"], catch_exceptions=False)
    assert "sure): They bought their offices from one another" in done.output
    assert '"bought"' in Path("b.TextGrid").read_text()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ((), "recognizing words, which is better, needs pip install 'phonanim[recognize]'"),
        (("--voice", "de"), "words are recognized in English alone, and giving them with --text is better"),
    ],
)
def test_phones_are_recognized_where_words_cannot_be(
    arguments: tuple[str, ...], why: str, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pocketsphinx")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(whisper, "can_recognize", lambda: False)
    whisper._model.cache_clear()
    Path("a.wav").write_bytes((root / "examples" / "line.wav").read_bytes())
    done = CliRunner().invoke(command, ["a.wav", "-o", "a.csv", *arguments], catch_exceptions=False)
    assert f"a.wav: {why}; so --model audio recognizes phones, many of them wrong" in done.output
    assert done.exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "a.wav"]
    with pytest.raises(OptionError if arguments else MissingExtraError, match=r"--text"):
        run("a.wav", "-o", "b.csv", "--model", "default", *arguments)


def test_words_that_are_not_clear_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared_data: Path
) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    monkeypatch.chdir(tmp_path)
    Path("b.wav").write_bytes((shared_data / "ema_de" / "dfgspp_mo1_prosody_0020.wav").read_bytes())
    with pytest.raises(OptionError, match=r"b\.wav: its words are not clear \(\d+% sure"):
        run("b.wav", "-o", "b.csv")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b.wav"]


def test_a_text_that_pocketsphinx_does_not_find(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared_data: Path
) -> None:
    pytest.importorskip("pocketsphinx")
    monkeypatch.chdir(tmp_path)
    Path("b.wav").write_bytes((shared_data / "textgrids" / "002_en_LJ006-0114.wav").read_bytes())
    text = "yes " * 30
    done = CliRunner().invoke(command, ["b.wav", "--text", text, "-o", "b.csv"], catch_exceptions=False)
    assert "aligned with speech of eSpeak NG instead" in done.output
    assert '"yes' in Path("b.TextGrid").read_text()
    assert done.exit_code == 0


SUBTITLES = """1
00:00:00,100 --> 00:00:03,000
they bought their offices from one another,

2
00:00:03,000 --> 00:00:06,100
and were thus considered to have a vested interest in them.
"""


def test_subtitles_are_aligned_within_their_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shared_data: Path
) -> None:
    pytest.importorskip("pocketsphinx")
    from phonanim.aligners.pocketsphinx import align

    monkeypatch.chdir(tmp_path)
    Path("b.wav").write_bytes((shared_data / "textgrids" / "002_en_LJ006-0114.wav").read_bytes())
    Path("b.srt").write_text(SUBTITLES)
    done = CliRunner().invoke(command, ["b.srt", "-o", "b.csv", "--rig", "arkit"], catch_exceptions=False)
    assert "the words of 1 lines are aligned within the time of each" in done.output
    assert "share its time by their letters" not in done.output
    right = align(
        Path("b.wav"),
        "they bought their offices from one another and were thus considered to "
        "have a vested interest in them",
    )
    found = read_alignment("b.aligned.TextGrid").words
    begins = [word.start for word in found if word.label]
    assert len(begins) == len(right.words)
    assert max(abs(a - b.start) for a, b in zip(begins, right.words, strict=True)) < 0.1
    first = Path("b.csv").read_bytes()
    assert run("b.srt", "-o", "b.csv", "--rig", "arkit")["audio"] == "b.wav"
    assert Path("b.csv").read_bytes() == first
    Path("b.aligned.TextGrid").write_text("mine")
    with pytest.raises(OptionError, match=r"b\.aligned\.TextGrid: is there already, with other times"):
        run("b.srt", "-o", "b.csv", "--rig", "arkit")
