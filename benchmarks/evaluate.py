"""Train models on the recordings and measure them where they have not been: clips, words, phones, speakers.

    python benchmarks/evaluate.py words benchmarks/configs/default.toml benchmarks/configs/tree.toml
    python benchmarks/evaluate.py test --model default=phonanim/models/default --json work/test.json

`validation` scores a tenth of the training clips, `words` and `phones` retrain with words or phones
withheld, `ema` compares lip aperture with two German utterances of another speaker, and `test` scores the
50 test clips, on which nothing is ever fitted or chosen. `oracle` fits on the test clips as well, and scores
them: what the same model could reach if it had learned from every sentence, a bound and not a result.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from phonanim import metrics, regressors
from phonanim.comparison.ema import ema_modes
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.ema import Utterance, load_utterances
from phonanim.face import contacts
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel, lip_aperture, lip_protrusion, lip_width
from phonanim.media.audio import read_sound
from phonanim.speech.inventory import INVENTORY
from phonanim.training.recipe import read_recipe
from phonanim.training.recipes import fit_recipe

ROOT = Path(__file__).parent.parent
# Each fold withholds a sentence word, three letters and a digit.
WORD_FOLDS = (
    ("place", "m", "o", "q", "five"),
    ("white", "b", "w", "r", "two"),
    ("please", "f", "y", "u", "eight"),
    ("with", "h", "x", "v", "seven"),
)
WITHHELD_PHONES = ("ch", "jh", "th", "aw")
Array = NDArray[np.float64]
Predict = Callable[[int], NDArray[np.float32]]  # clip -> (frames, modes)
Where = Callable[[int], NDArray[np.bool_]]  # clip -> (frames,)
Fold = tuple[Predict, list[int], Where]
Row = dict[str, Any]


class Judge:
    """The corpus, the reference face of its training clips, and what there is to measure."""

    def __init__(self, folder: Path) -> None:
        self.corpus: Corpus = load_corpus(folder)
        self.train = self.corpus.clips_of("train")
        self.face: FaceModel = fit_face(
            self.corpus.landmarks[self.corpus.rows(self.train)], self.corpus.indices
        )

    def speech(self, clip: int) -> NDArray[np.bool_]:
        """Frames of a clip that hold speech."""
        return metrics.speech_mask(self.corpus.tracks[clip], self.corpus.times(clip))

    def in_words(self, clip: int, words: tuple[str, ...]) -> NDArray[np.bool_]:
        """Frames of a clip that lie in some words."""
        times = self.corpus.times(clip)
        inside = [(times >= w.start) & (times < w.end) for w in self.corpus.words[clip] if w.label in words]
        return np.any([np.zeros(len(times), bool), *inside], axis=0)

    def near_phones(self, clip: int, phones: tuple[str, ...]) -> NDArray[np.bool_]:
        """Frames of some phones and of the phones beside them, silence left out."""
        track = self.corpus.tracks[clip]
        chosen = np.isin(track.codes, INVENTORY.codes(phones))
        chosen = chosen | np.roll(np.append(chosen, False), 1)[:-1] | np.append(chosen[1:], False)
        segments = track.segment_at(self.corpus.times(clip))
        return chosen[segments] & self.speech(clip)

    def lips(self, predict: Predict, clips: Iterable[int], where: Where) -> Row:
        """Correlation of aperture, width and protrusion over chosen frames of clips, pooled."""
        return pooled(self, [(predict, [int(c) for c in clips], where)])

    def clips(self, predict: Predict, clips: Iterable[int]) -> Row:
        """Everything about whole clips."""
        clips = [int(c) for c in clips]
        captured = self.corpus.landmarks[self.corpus.rows(clips)]
        shapes = self.face.instance(np.concatenate([predict(c) for c in clips]))
        error = metrics.vertex_error(shapes, captured, self.face)
        speech = np.concatenate([self.speech(c) for c in clips])
        everywhere = self.lips(predict, clips, lambda c: np.ones(int(self.corpus.frames[c]), bool))
        spoken = self.lips(predict, clips, self.speech)
        return {
            "vertex_error_mm": float(error.mean()),
            "vertex_error_speech_mm": float(error[speech].mean()),
            **everywhere,
            **{f"{name}_speech": value for name, value in spoken.items()},
            "pbm_gap_mm": self.closure_gap(predict, clips),
        }

    def closure_gap(self, predict: Predict, clips: Iterable[int]) -> float:
        """Mean predicted lip gap at the frame nearest to the middle of every p, b and m, in mm."""
        gaps = []
        for clip in clips:
            frames = np.round(
                metrics.phone_middles(self.corpus.tracks[clip], ("p", "b", "m")) * self.corpus.fps - 0.5
            )
            frames = np.clip(frames, 0, self.corpus.frames[clip] - 1).astype(int)
            gaps.append(metrics.lip_gap(self.face.instance(predict(clip)[frames]), self.face))
        return float(np.concatenate(gaps).mean())


def cached(predict: Predict) -> Predict:
    """Predict every clip once."""
    found: dict[int, NDArray[np.float32]] = {}

    def once(clip: int) -> NDArray[np.float32]:
        if clip not in found:
            found[clip] = predict(clip)
        return found[clip]

    return once


def predictor(model: regressors.Model, corpus: Corpus, closing: bool) -> Predict:
    """A model on the clips of a corpus; with `closing`, contacts are applied as `animate` does."""

    def predict(clip: int) -> NDArray[np.float32]:
        start = 0.5 / corpus.fps
        sound = None if model.regressor.input_modality == "phones" else read_sound(corpus.audio[clip])
        modes = model.predict(corpus.tracks[clip], corpus.fps, int(corpus.frames[clip]), start, sound)
        return (
            contacts.enforce_lip_contacts(modes, corpus.tracks[clip], model.face, corpus.times(clip))
            if closing
            else modes
        )

    return cached(predict)


FITTED: dict[tuple[Path, bytes], regressors.Model] = {}


def fit(config: Path, judge: Judge, clips: NDArray[np.int64]) -> regressors.Model:
    """Train a recipe on some clips, once; with the face of all training clips, so that measures compare."""
    key = config, clips.tobytes()
    if key not in FITTED:
        recipe = read_recipe(config)
        FITTED[key] = fit_recipe(recipe, judge.corpus, clips, recipe.seed, config, face=judge.face)
    return FITTED[key]


def validation(config: Path, judge: Judge, closing: bool) -> Row:
    """A tenth of the training clips, the others trained on."""
    shuffled = np.random.default_rng(0).permutation(judge.train)
    held_out, rest = np.sort(shuffled[:89]), np.sort(shuffled[89:])
    return judge.clips(predictor(fit(config, judge, rest), judge.corpus, closing), held_out)


def words(config: Path, judge: Judge, closing: bool) -> Row:
    """Leave words out: clips with a withheld word are never trained on; scored in them and in the word."""
    gathered: dict[str, list[Fold]] = {"word": [], "clip": []}
    for fold in WORD_FOLDS:
        holds = np.array([any(w.label in fold for w in judge.corpus.words[c]) for c in judge.train])
        predict = predictor(fit(config, judge, judge.train[~holds]), judge.corpus, closing)
        held_out = [int(c) for c in judge.train[holds][::3]]
        gathered["word"].append((predict, held_out, lambda c, fold=fold: judge.in_words(c, fold)))
        gathered["clip"].append((predict, held_out, judge.speech))
    return {
        f"{name}_in_{where}": value
        for where, folds in gathered.items()
        for name, value in pooled(judge, folds).items()
    }


def pooled(judge: Judge, folds: list[Fold]) -> Row:
    """Correlations over the chosen frames of several folds together."""
    shapes, captured = [], []
    for predict, clips, where in folds:
        rows = np.concatenate([where(clip) for clip in clips])
        captured.append(judge.corpus.landmarks[judge.corpus.rows(clips)][rows])
        shapes.append(judge.face.instance(np.concatenate([predict(clip) for clip in clips])[rows]))
    return correlations(np.concatenate(shapes), np.concatenate(captured), judge.face)


def correlations(shapes: NDArray[np.floating], captured: NDArray[np.floating], face: FaceModel) -> Row:
    """R of lip aperture, width and protrusion, (frames, landmarks, 3) each."""
    measures = {"aperture_r": lip_aperture, "width_r": lip_width, "protrusion_r": lip_protrusion}
    return {name: metrics.correlation(f(shapes, face), f(captured, face)) for name, f in measures.items()}


def phones(config: Path, judge: Judge, closing: bool) -> Row:
    """Leave phones out: as if ch, jh, th, aw had never been recorded; scored on them and their neighbours."""
    codes = INVENTORY.codes(WITHHELD_PHONES)
    holds = np.array([np.isin(judge.corpus.tracks[c].codes, codes).any() for c in judge.train])
    predict = predictor(fit(config, judge, judge.train[~holds]), judge.corpus, closing)
    held_out = judge.train[holds][::2]
    row = judge.lips(predict, held_out, lambda c: judge.near_phones(c, WITHHELD_PHONES))
    for phone in WITHHELD_PHONES:
        found = judge.lips(predict, held_out, lambda c, phone=phone: judge.near_phones(c, (phone,)))
        row[f"aperture_r_{phone}"] = found["aperture_r"]
    return row


def ema(model: regressors.Model, utterances: list[Utterance], closing: bool) -> Row:
    """Lip aperture against the distance of lip sensors, over speech: per utterance, and their mean."""
    found = []
    for utterance in utterances:
        aperture = lip_aperture(model.face.instance(ema_modes(model, utterance, closing)), model.face)
        found.append(metrics.correlation(aperture[utterance.speech], utterance.aperture[utterance.speech]))
    return {
        "aperture_r_mean": float(np.mean(found)),
        **{f"aperture_r_{i + 1}": r for i, r in enumerate(found)},
    }


@click.command(help=__doc__)
@click.argument("what", type=click.Choice(["validation", "words", "phones", "ema", "test", "oracle"]))
@click.argument("configs", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--model", "models", multiple=True, help="NAME=FOLDER of a trained model (ema, test).")
@click.option("--corpus", "folder", default=ROOT / "work/corpus", type=click.Path(path_type=Path))
@click.option("--data", default=ROOT.parent / "shared/data", type=click.Path(path_type=Path), help="For ema.")
@click.option("--stamp", is_flag=True, help="Write the test scores into the models' model.json.")
@click.option("--json", "output", type=click.Path(path_type=Path), help="Add the rows to this file.")
def main(
    what: str,
    configs: tuple[Path, ...],
    models: tuple[str, ...],
    folder: Path,
    data: Path,
    stamp: bool,
    output: Path | None,
) -> None:
    judge = Judge(folder)
    trained = {n: regressors.load(Path(p)) for n, _, p in (m.partition("=") for m in models)}
    folds = {"validation": validation, "words": words, "phones": phones}
    utterances = load_utterances(data / "ema_de") if what == "ema" else []
    rows: dict[str, Row] = {}
    known = np.arange(len(judge.corpus.clips)) if what == "oracle" else judge.train
    for name, subject in {**{c.stem: c for c in configs}, **trained}.items():
        for closing in (False, True):
            label = name + (" + contacts" if closing else "")
            if what in folds and isinstance(subject, Path):
                rows[label] = folds[what](subject, judge, closing)
            else:
                model = fit(subject, judge, known) if isinstance(subject, Path) else subject
                clips = judge.corpus.clips_of("test")
                rows[label] = (
                    ema(model, utterances, closing)
                    if what == "ema"
                    else judge.clips(predictor(model, judge.corpus, closing), clips)
                )
            show(label, rows[label])
        if output:
            keep(output, what, rows)
    if stamp and what == "test":
        for name, _, path in (m.partition("=") for m in models):
            write_scores(Path(path) / "model.json", rows[f"{name} + contacts"])


def write_scores(card: Path, row: Row) -> None:
    """Put what a model reaches on the test clips, contacts included, into its model.json."""
    document = json.loads(card.read_text(encoding="utf-8"))
    scores = {f"test_{key}": round(value, 3) for key, value in row.items()}
    document["provenance"]["scores"].update(scores)
    card.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def keep(output: Path, what: str, rows: dict[str, Row]) -> None:
    """Add rows to a JSON file of results, so that a long run may be cut off."""
    whole = json.loads(output.read_text()) if output.exists() else {}
    whole.setdefault(what, {}).update(rows)
    output.write_text(json.dumps(whole, indent=1) + "\n")


def show(name: str, row: Row) -> None:
    print(f"{name:<26}", "  ".join(f"{key} {value:.3f}" for key, value in row.items()), flush=True)


if __name__ == "__main__":
    sys.exit(main())
