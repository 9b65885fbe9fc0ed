"""An imported data set -> a training corpus of its controls, sensors or vertices."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, decode_number, decode_part, read_array, read_json, read_utf8
from phonanim.corpus.importing import import_dataset
from phonanim.corpus.motion import MotionClip, MotionCorpus, save_motion_corpus
from phonanim.datasets import KINDS, SPLITS
from phonanim.errors import CorpusError
from phonanim.inputs.alignment import read_alignment
from phonanim.speech.alignment import Interval
from phonanim.speech.language import to_phones
from phonanim.speech.phones import silent_track
from phonanim.targets import Source

Array = NDArray[np.float64]
MAX_TABLE = 1 << 26  # bytes of recordings.csv
NO_SPLIT = "the data set has no split: every tenth recording is a test"
NO_NAMES = "the controls have no names and are numbered from 0; --names FILE names them"
NO_TEMPLATES = "no faces at rest: the first frame of each subject stands for it; --template gives better ones"
EVERY_TENTH = 10  # recordings of a data set without a split: this one of as many is a test


def build_from_dataset(
    name: str,
    folder: Path,
    destination: Path,
    every: int = 1,
    templates: Mapping[str, Array] | None = None,
    language: str = "auto",
    triangles: NDArray[np.int64] | None = None,
    progress: Callable[[float], None] = lambda done: None,
    names: tuple[str, ...] = (),
    without: NDArray[np.int64] | None = None,
) -> MotionCorpus:
    """Import a data set as its owners lay it out, into the folder of the corpus, and build the corpus.

    `without` (n,) are vertices that are left out. Raises what `import_dataset` and `build_motion_corpus`
    raise.
    """
    import_dataset(
        name, folder, destination, every, progress=lambda done: progress(0.9 * done), without=without
    )
    corpus = build_motion_corpus(destination, destination, templates, language, triangles, names)
    progress(1.0)
    return corpus


def build_motion_corpus(
    imported: Path,
    destination: Path,
    templates: Mapping[str, Array] | None = None,
    language: str = "auto",
    triangles: NDArray[np.int64] | None = None,
    names: tuple[str, ...] = (),
) -> MotionCorpus:
    """Write the corpus of a folder that `phonanim corpus import` wrote, with links to its motion and sound.

    Recordings without a split take no part, unless the data set has no split at all: then every tenth is a
    test. `templates` are faces at rest by subject, in the unit of the vertices, "" of all subjects; without
    them those of the data set, else the first frame of each subject. `triangles` (n, 3) are those of the
    mesh. `names` are those of controls, in place of the data set's. Raises CorpusError.
    """
    facts, rows = read_imported(imported)
    guessed = list(guess_splits(rows))
    used = [row for row in rows if row["split"] and int(row["frames"]) > 0]
    if not any(row["split"] == "train" for row in used):
        raise CorpusError(
            f"{imported / 'recordings.csv'}: has no recordings to train on; import the split train"
        )
    fps = float(facts["fps"])
    clips = tuple(read_clip(row, imported, fps, language) for row in used)
    if str(facts["kind"]) == "controls":
        names = names or tuple(facts["names"])
        guessed += [] if names else [NO_NAMES]
    elif names:
        raise CorpusError(f"--names: {facts['kind']} have none; leave it out")
    unit = str(facts["unit"])
    source = Source(str(facts.get("name") or imported.name), names, unit, {}, triangles)
    about = {"source": imported.name, **card_of(facts), "guessed": guessed}
    corpus = MotionCorpus(str(facts["kind"]), fps, source, clips, about)
    check_names(names, corpus)
    if corpus.kind == "vertices":
        known = templates or imported_templates(imported)
        guessed += [] if known else [NO_TEMPLATES]
        rests = dict(known or first_frames(corpus))
        if "" in rests:
            rests = dict.fromkeys(sorted({clip.subject for clip in clips}), rests[""])
        source = Source(source.data, source.names, source.unit, rests, triangles)
        corpus = MotionCorpus(corpus.kind, fps, source, clips, corpus.provenance)
        check_templates(corpus)
    save_motion_corpus(corpus, destination)
    return corpus


def read_imported(folder: Path) -> tuple[dict[str, Any], list[dict[str, str]]]:
    """The facts and the recordings of an imported folder. Raises CorpusError."""
    path, table = folder / "dataset.json", folder / "recordings.csv"
    try:
        facts = read_json(path)
        kind, fps = facts["kind"], decode_number(facts["fps"], "fps", 0.1, 1e5)
        names = [str(name) for name in facts["names"]]
        if kind not in KINDS:
            raise ValueError(f"its kind is {kind!r}, not {', '.join(KINDS)}")
        rows = list(csv.DictReader(io.StringIO(read_utf8(table, MAX_TABLE), newline="")))
        for number, row in enumerate(rows, start=2):
            decode_part(row["name"], f"recordings.csv row {number}: name")
            if row["split"] not in SPLITS or not row["frames"].isdecimal() or len(row["frames"]) > 9:
                raise ValueError(f"recordings.csv row {number} needs a name, a number of frames and a split")
    except (OSError, csv.Error, *DAMAGE) as error:
        raise CorpusError(
            f"{folder}: is not an imported data set ({error}); use phonanim corpus import"
        ) from error
    return {**facts, "fps": fps, "names": names, "unit": facts.get("unit", "")}, rows


def guess_splits(rows: Sequence[dict[str, str]]) -> tuple[str, ...]:
    """Make every tenth recording a test where no recording has a split; -> a line that says so, or none."""
    if any(row["split"] for row in rows):
        return ()
    for number, row in enumerate(rows):
        row["split"] = "test" if number % EVERY_TENTH == EVERY_TENTH - 1 else "train"
    return (NO_SPLIT,)


def card_of(facts: Mapping[str, Any]) -> dict[str, str]:
    """Title, source and licence of a data set."""
    return {key: str(facts[key]) for key in ("title", "source", "licence") if facts.get(key)}


def read_clip(row: Mapping[str, str], folder: Path, fps: float, language: str) -> MotionClip:
    """A row of the table with its files. Raises CorpusError where the motion is missing."""
    name, frames = row["name"], int(row["frames"])
    motion, audio = folder / "motion" / f"{name}.npy", folder / "audio" / f"{name}.wav"
    if not motion.is_file():
        raise CorpusError(f"{motion}: is missing; import the data set again")
    grid = folder / "textgrid" / f"{name}.TextGrid"
    track, words = silent_track(frames / fps), tuple[Interval, ...]()
    if grid.is_file():
        alignment = read_alignment(grid)
        track = to_phones(alignment, language, unknown="nearest")[0]
        words = tuple(word for word in alignment.words if word.label)
    return MotionClip(
        name, row["speaker"], row["split"], frames, motion, audio if audio.is_file() else None,
        track, words, grid.is_file(), row.get("emotion") or "",
    )  # fmt: skip


def imported_templates(folder: Path) -> dict[str, Array]:
    """Faces at rest that the import wrote, templates/<subject>.npy. Raises CorpusError."""
    found = {}
    for path in sorted((folder / "templates").glob("*.npy")):
        try:
            found[path.stem] = read_array(path).astype(np.float64)
        except (OSError, ValueError, TypeError) as error:
            raise CorpusError(f"{path}: cannot be read ({error}); import the data set again") from error
    return found


def first_frames(corpus: MotionCorpus) -> dict[str, Array]:
    """The first frame of each subject, (vertices, 3), for data sets without faces at rest."""
    found: dict[str, Array] = {}
    for number, clip in enumerate(corpus.clips):
        if clip.subject not in found:
            found[clip.subject] = np.asarray(corpus.frames(number)[0], np.float64)
    return found


def check_names(names: tuple[str, ...], corpus: MotionCorpus) -> None:
    """Raise CorpusError where names are not one for each control."""
    count = corpus.frames(0).shape[1]
    if names and len(names) != count:
        raise CorpusError(
            f"there are {len(names)} names, and a frame has {count} controls; give one for each"
        )
    if twice := [name for name in names if names.count(name) > 1]:
        raise CorpusError(f"two controls are called {twice[0]!r}; give each another name")


def check_templates(corpus: MotionCorpus) -> None:
    """Raise CorpusError where a subject has no face at rest, or one of another mesh."""
    for number, clip in enumerate(corpus.clips):
        rest, shape = corpus.rest(number), corpus.frames(number).shape[1:]
        if rest is None:
            raise CorpusError(
                f"{clip.name}: its subject {clip.subject} has no template; give --template with one of each"
            )
        if rest.shape != shape:
            raise CorpusError(f"{clip.name}: has frames of {shape}, and the template is of {rest.shape}")
    triangles = corpus.source.triangles
    if triangles is not None and triangles.max() >= shape[0]:
        raise CorpusError(f"the mesh has more vertices than the frames of {corpus.source.data} ({shape[0]})")
