"""Words that a network of isolated words reads: from filmed mouths, and from the shipped head.

    python benchmarks/words.py NETWORK WORDS ARCHIVE --count 60 --films RECORDINGS/grid_s1
    python benchmarks/words.py NETWORK WORDS ARCHIVE --lines work/words --model models/procedural
    work/openfacefx/bin/python benchmarks/openfacefx_tracks.py work/words -o work/openfacefx_tracks
    python benchmarks/words.py NETWORK WORDS ARCHIVE --tracks work/openfacefx_tracks

ARCHIVE is RECORDINGS/textgrids/ljspeech_mfa_3000.tar.xz. The lines are spread over it; of each, one word that
the network knows is read. --films shows first whether the network reads a man who was filmed: test clips of
recordings with mouth/ films, and the same words on the head. --lines keeps the lines, for other tools, whose
curves --tracks reads. The first row of each table is what a guess reaches that takes any word of the list.
The table of --model is that of docs/measures.md; brackets are 95 % intervals over words.
"""

from __future__ import annotations

import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.core.tables import read_rows
from phonanim.evaluation.word_errors import Spelled, spell_visemes, word_summary, word_sums
from phonanim.evaluation.words import (
    FPS,
    FRAMES,
    GREY,
    SIZE,
    WordRead,
    WordReader,
    load_word_reader,
    read_words,
)
from phonanim.exporters import load
from phonanim.inputs.alignment import read_alignment
from phonanim.media.video import read_clip
from phonanim.pipeline import animate
from phonanim.speech.alignment import Interval

Spoken = tuple[Path, Interval]

WAYS = {"lips alone": "direct", "with articulation": "auto"}
COLUMNS = {"wer": "WER", "cer": "CER", "viseme_error": "viseme errors", "top5": "among five"}
HEADER = (
    f"| mouth | {' | '.join(COLUMNS.values())} | median rank | log p |\n|---|{'---:|' * (len(COLUMNS) + 2)}"
)
PUPILS = 46.0  # pixels between the pupils in the films of grid_s1
LRW_PUPILS = 54.0  # in the pictures that the network knows
LIPS = (61, 291, 0, 17)  # MediaPipe face-mesh numbers around the mouth
LONGEST = 0.9  # seconds: a longer word does not fit into the pictures
EDGE = 0.6  # seconds from the ends of a line


def lines_of(archive: Path, folder: Path) -> Iterator[Path]:
    """Every alignment of an archive, in an order that is spread over it."""
    with tarfile.open(archive) as stored:
        members = sorted((one for one in stored if one.name.endswith(".TextGrid")), key=lambda one: one.name)
        for place in range(len(members)):
            member = members[place * 997 % len(members)]
            file = stored.extractfile(member)
            path = folder / Path(member.name).name
            path.write_bytes(file.read() if file else b"")
            yield path


def known_word(path: Path, known: tuple[str, ...]) -> Interval | None:
    """The longest word of a line that the network knows."""
    words = read_alignment(path).words
    fits = [
        word
        for word in words
        if word.label.lower() in known
        and word.end - word.start < LONGEST
        and EDGE < word.start < words[-1].end - EDGE
    ]
    return max(fits, key=lambda word: word.end - word.start, default=None)


@click.command(help=__doc__)
@click.argument("network", type=click.Path(exists=True, path_type=Path))
@click.argument("words", type=click.Path(exists=True, path_type=Path))
@click.argument("archive", type=click.Path(exists=True, path_type=Path))
@click.option("--count", default=60, show_default=True)
@click.option("--films", type=click.Path(exists=True, path_type=Path), help="Recordings with mouth/ films.")
@click.option("--lines", type=click.Path(path_type=Path), help="Folder that keeps the lines that are read.")
@click.option("--model", "models", multiple=True, help="Another model, by its lips alone.")
@click.option("--tracks", type=click.Path(exists=True, path_type=Path), help="Curves of another tool.")
def main(
    network: Path,
    words: Path,
    archive: Path,
    count: int,
    films: Path | None,
    lines: Path | None,
    models: tuple[str, ...],
    tracks: Path | None,
) -> None:
    reader = load_word_reader(network, words)
    spelled = spell_visemes(reader.words)
    if films:
        filmed = list(filmed_words(films, reader))
        spoken = [(path, word) for path, word, _ in filmed]
        start_table(spoken, reader, spelled)
        print_row("filmed mouths", [read for _, _, read in filmed], spelled)
        for way, how in WAYS.items():
            print_row(f"the same words, {way}", read_lines(spoken, reader, how=how), spelled)
    with tempfile.TemporaryDirectory() as folder:
        chosen = choose_words(archive, Path(folder), reader.words, count)
        if lines:
            keep_lines([path for path, _ in chosen], lines)
        start_table(chosen, reader, spelled)
        for model in ("default", *models):
            name = "phonanim" if model == "default" else Path(model).name
            for way, how in WAYS.items():
                print_row(f"{name}, {way}", read_lines(chosen, reader, model, how), spelled)
        if tracks:
            takes = [(load(tracks / f"{path.stem}.track.json"), word) for path, word in chosen]
            found = [one for take, word in takes for one in read_words(take, reader, [word])]
            print_row(tracks.name, found, spelled)


def start_table(spoken: list[Spoken], reader: WordReader, spelled: Spelled) -> None:
    """How much is read, the head of a table, and the errors of a guess that takes any word of the list."""
    seconds = sum(word.end - word.start for _, word in spoken)
    lines, shown = len({path for path, _ in spoken}), len(spoken) * FRAMES / FPS
    print(f"\n{len(spoken)} words of {lines} lines, {seconds:.0f} s of words in {shown:.0f} s of pictures\n")
    print(HEADER)
    chance, listed = -float(np.log(len(reader.words))), len(reader.words)
    guesses = [
        WordRead(word.label.lower(), 1 + place, chance, guess)
        for _, word in spoken
        for place, guess in enumerate(reader.words)
    ]
    rates = {name: sums.sum(axis=0) for name, sums in word_sums(guesses, spelled.visemes).items()}
    shares = [f"{rates[name][0] / rates[name][1]:.1%}" for name in COLUMNS]
    print(
        f"| any word of the list | {' | '.join(shares)} | {(listed + 1) / 2:g} | {chance:.2f} |", flush=True
    )


def choose_words(archive: Path, folder: Path, known: tuple[str, ...], count: int) -> list[Spoken]:
    """Lines of an archive, each with a word that the network knows."""
    chosen: list[Spoken] = []
    for path in lines_of(archive, folder):
        word = known_word(path, known)
        if word is not None:
            chosen.append((path, word))
        if len(chosen) == count:
            break
    return chosen


def keep_lines(paths: list[Path], folder: Path) -> None:
    """Copy lines into a folder of recordings, whose test clips they are."""
    (folder / "textgrid").mkdir(parents=True, exist_ok=True)
    for path in paths:
        (folder / "textgrid" / path.name).write_bytes(path.read_bytes())
    rows = "".join(f"{path.stem},test\n" for path in paths)
    (folder / "clips.csv").write_text("clip,split\n" + rows, "utf-8")


def read_lines(
    spoken: list[Spoken], reader: WordReader, model: str = "default", how: str = "auto"
) -> list[WordRead]:
    """What is read of each word, on the shipped head."""
    found = []
    for path, word in spoken:
        take = animate(path, rig="arkit", fps=50, life=0.0, model=model, retarget=how)
        found += read_words(take, reader, [word])
    return found


def filmed_words(recordings: Path, reader: WordReader) -> Iterator[tuple[Path, Interval, WordRead]]:
    """Words of the test clips of filmed recordings, with their alignments, as the network reads the films."""
    rows = read_rows(recordings / "clips.csv")
    columns = {name: rows[0].index(name) for name in ("clip", "split", "crop_x", "crop_y")}
    stored = np.load(recordings / "landmarks.npz")
    clips, ends = stored["clips"].tolist(), np.cumsum(stored["frames"])
    points = np.cumsum(stored["delta"].astype(np.int32), axis=0)[:, :, :2] * stored["scale"]
    lips = [stored["indices"].tolist().index(number) for number in LIPS]
    for row in rows[1:]:
        if row[columns["split"]] != "test":
            continue
        clip = row[columns["clip"]]
        grid, place = recordings / "textgrid" / f"{clip}.TextGrid", clips.index(clip)
        known = [word for word in read_alignment(grid).words if word.label.lower() in reader.words]
        corner = np.array([float(row[columns["crop_x"]]), float(row[columns["crop_y"]])])
        around = points[ends[place] - stored["frames"][place] : ends[place], lips] - corner
        film = np.asarray(read_clip(recordings / "mouth" / f"{clip}.mp4")) @ GREY if known else np.zeros(0)
        for word in known:
            middle = (word.start + word.end) / 2 * FPS - 0.5
            frames = np.clip(round(middle) + np.arange(FRAMES) - FRAMES // 2, 0, len(film) - 1)
            scores = reader.score(cropped(film[frames], around[frames].mean(axis=(0, 1))))
            said = reader.words.index(word.label.lower())
            rank, best = 1 + int((scores > scores[said]).sum()), reader.words[int(scores.argmax())]
            yield grid, word, WordRead(word.label.lower(), rank, float(scores[said]), best)


def cropped(film: NDArray[np.float64], centre: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Grey pictures around a point, at the size of a face that the network knows, (frames, SIZE, SIZE)."""
    from PIL import Image

    wide = SIZE * PUPILS / LRW_PUPILS
    corner, step = centre - wide / 2, wide / SIZE
    matrix = (step, 0.0, corner[0], 0.0, step, corner[1])
    pictures = [Image.fromarray(np.round(frame).astype(np.uint8)) for frame in film]
    way = Image.Transform.AFFINE
    return np.stack(
        [np.asarray(one.transform((SIZE, SIZE), way, matrix, Image.Resampling.BICUBIC)) for one in pictures]
    )


def print_row(name: str, found: list[WordRead], spelled: Spelled) -> None:
    """A row of the table."""
    total = word_summary(found, spelled)
    ends = total["intervals"]
    rates = [f"{total[key]:.0%} [{ends[key][0]:.0%}, {ends[key][1]:.0%}]" for key in COLUMNS]
    low, high = ends["word_log_p"]
    log_p = f"{total['word_log_p']:.2f} [{low:.2f}, {high:.2f}]"
    print(f"| {name} | {' | '.join(rates)} | {total['median_rank']:g} | {log_p} |", flush=True)


if __name__ == "__main__":
    main()
