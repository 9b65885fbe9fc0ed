"""Long recordings, and texts that are partly wrong."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
import pytest

from phonanim.aligners._matching import match_words
from phonanim.aligners.long import align_long, align_recording
from phonanim.aligners.pocketsphinx import split_words
from phonanim.errors import AlignmentError, OptionError

SAID = "they bought their offices from one another and were thus considered to have a vested interest in them"


def pairs_of(text: str, recognized: str) -> list[tuple[int, int]]:
    return match_words(text.split(), recognized.split())


def test_words_are_matched_between_anchors() -> None:
    text = "a b c d e f g h"
    assert pairs_of(text, text) == [(n, n) for n in range(8)]
    assert pairs_of(text, "a b c X e f g h") == [(n, n) for n in (0, 1, 2, 4, 5, 6, 7)]
    assert pairs_of(text, "Y a b c e f g h") == [(0, 1), (1, 2), (2, 3), (4, 4), (5, 5), (6, 6), (7, 7)]
    assert pairs_of(text, "") == []


def test_repeated_words_are_no_anchors() -> None:
    pairs = pairs_of("no no no no yes it is so no no", "no no yes it is so no no no")
    assert pairs == sorted(pairs)
    assert {(4, 2), (5, 3), (6, 4), (7, 5)} <= set(pairs)


def test_a_text_of_hours_is_matched() -> None:
    words = [str(n % 9973 if n % 5 else n) for n in range(20_000)]
    recognized = [word for n, word in enumerate(words) if n % 10]
    assert len(match_words(words, recognized)) > 17_000


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("their offices", "offices"),
        ("considered to", "considered very much to"),
        ("bought", "sold"),
        ("thus considered", "considered thus"),
    ],
)
def test_a_text_with_wrong_words_is_aligned(old: str, new: str, shared_data: Path) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    pytest.importorskip("pocketsphinx")
    recording = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    right, wrong = (align_long(recording, text, None) for text in (SAID, SAID.replace(old, new)))
    begins = {word.label: word.start for word in right.words if split_words(SAID).count(word.label) == 1}
    common = [word for word in wrong.words if word.label in begins and word.label not in f"{old} {new}"]
    assert len(common) >= 12
    assert max(abs(word.start - begins[word.label]) for word in common) < 0.15


def test_another_text_is_refused(shared_data: Path) -> None:
    pytest.importorskip("ctranslate2", reason="needs the extra recognize")
    pytest.importorskip("pocketsphinx")
    recording = shared_data / "textgrids" / "002_en_LJ006-0114.wav"
    with pytest.raises(
        AlignmentError, match=r"only \d+% of the text is recognized in it; check that they match"
    ):
        align_long(recording, "twelve green bottles hanging on a garden wall", None)


@pytest.fixture
def spoken(tmp_path: Path) -> tuple[Path, str, list[float]]:
    """A recording of five German sentences with a chord after the third, its text, its words' begins."""
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    from phonanim.aligners.espeak import speak

    sentences = [
        "Guten Morgen, meine Damen und Herren.",
        "Heute sprechen wir über das Wetter in den Bergen.",
        "Am Abend kommt ein starker Wind aus dem Norden.",
        "Morgen früh scheint wieder die Sonne über der Stadt.",
        "Vielen Dank und auf Wiedersehen.",
    ]
    pieces, begins, length = [], [], 0
    for number, sentence in enumerate(sentences):
        made = speak(sentence, "de", 160)
        begins += [length / made.rate + word.start for word in made.words]
        pieces.append(made.samples)
        if number == 2:
            times = np.arange(8 * made.rate) / made.rate
            tones = sum(np.sin(2 * np.pi * hertz * times) for hertz in (220.0, 277.2, 329.6))
            pieces.append((3000 * tones).astype(np.int16))
        length = sum(map(len, pieces))
    path = tmp_path / "de.wav"
    with wave.open(str(path), "wb") as stream:
        stream.setparams((1, 2, made.rate, 0, "NONE", ""))
        stream.writeframes(np.concatenate(pieces).astype("<i2").tobytes())
    return path, " ".join(sentences), begins


def test_made_speech_finds_sentences_around_music(spoken: tuple[Path, str, list[float]]) -> None:
    path, text, begins = spoken
    found = align_long(path, text, "de")
    assert [word.label for word in found.words] == [word.strip(".,") for word in text.split()]
    errors = np.abs(np.subtract([word.start for word in found.words], begins))
    assert np.median(errors) < 0.03
    assert errors.max() < 0.3


def test_short_recordings_are_aligned_at_once(root: Path) -> None:
    pytest.importorskip("pocketsphinx")
    found, language = align_recording(root / "examples/line.wav", "My father watched Bob move a lamp", None)
    assert language == "english"
    assert found.words[0].label == "my"


@pytest.mark.parametrize("voice", [None, "en-us"])
def test_what_is_not_spoken_of_a_text_is_not_looked_for(root: Path, voice: str | None) -> None:
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    text = "ANNA: (sighs) My father watched <i>Bob</i> move a cheap blue lamp [pause] from the wash room."
    found, _ = align_recording(root / "examples/line.wav", text, voice)
    said = " ".join(word.label.lower() for word in found.words)
    assert said == "my father watched bob move a cheap blue lamp from the wash room"
    assert found.notes[:2] == ("marks, not spoken: <i> </i>", "speakers, not spoken: ANNA:")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the text has no words"),
        ("[music]", r"the text has no words \(directions, not spoken: \[music\]\)"),
        ("My father watched Боб", "the voice en-us cannot read Боб; name its language, such as --voice ru"),
    ],
)
def test_texts_that_cannot_be_spoken(root: Path, text: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        align_recording(root / "examples/line.wav", text, None)
