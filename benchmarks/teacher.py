"""What the teacher's members and their mixtures reach where they have not been (docs/decisions/0009).

    python benchmarks/teacher.py benchmarks/compare.toml [--fold words2] [--member hmm]

Every member is trained on nine tenths of the training clips, without the second fold of words, and without
the withheld phones of the plan, and measured on what was left out. Nothing looks at the test clips. The
published network is no member of a mixture: it is there for comparison, with its seven epochs of plain
descent (some 13 minutes of a processor a fold) and as a copy of 3 x 256 units that is trained for longer.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from phonanim.comparison.fit import load_cached_corpus, reference_face
from phonanim.comparison.folds import Fold, all_frames, make_folds, speech_frames
from phonanim.comparison.plan import Plan, read_plan
from phonanim.comparison.scores import clip_scores, measure_value
from phonanim.core.threads import use_one_thread
from phonanim.corpus.corpus import Corpus
from phonanim.corpus.examples import make_examples
from phonanim.training.recipe import read_recipe

CONFIGS = Path(__file__).parent / "configs"
RECURRENT = {"features": "gestures", "rate": 4e-3, "epochs": 12}
MEMBERS = {
    "forest": ("forest", {}),
    "network on gestures": ("network_gestures", {}),
    "network on all": ("network_gestures", {"features": "all"}),
    "hmm": ("hmm", {}),
    "lstm, triphones": ("lstm", {}),
    "lstm, gestures": ("lstm", RECURRENT),
    "lstm, all": ("lstm", {**RECURRENT, "features": "all"}),
    "procedural": ("procedural", {}),
    "published network": ("taylor2017", {}),
    "published network, 3 x 256": ("published_copy", {}),
}
MIXTURES = {
    "the teacher before": {
        "forest": 0.35,
        "network on gestures": 0.35,
        "network on all": 0.15,
        "procedural": 0.15,
    },
    "the teacher now": {"forest": 0.25, "lstm, gestures": 0.4, "hmm": 0.25, "procedural": 0.1},
    "two recurrent": {
        "forest": 0.2,
        "lstm, gestures": 0.25,
        "lstm, all": 0.25,
        "hmm": 0.2,
        "procedural": 0.1,
    },
    "all instead of gestures": {"forest": 0.25, "lstm, all": 0.4, "hmm": 0.25, "procedural": 0.1},
    "with triphones": {
        "forest": 0.2,
        "lstm, gestures": 0.3,
        "lstm, triphones": 0.2,
        "hmm": 0.2,
        "procedural": 0.1,
    },
}
MEASURED = ("shape_mse", "aperture_r", "width_r")
HELD_OUT = 0.02  # of the training clips, for early stopping
Modes = NDArray[np.float64]


def settings_of_folds(plan: Plan, corpus: Corpus) -> Iterator[Fold]:
    """A tenth of the training clips held out, then the second fold of words and that of phones."""
    shuffled = np.random.default_rng(0).permutation(corpus.clips_of("train"))
    count = round(0.1 * len(shuffled))
    where = {"all": all_frames, "speech": speech_frames}
    yield Fold("validation", np.sort(shuffled[count:]), np.sort(shuffled[:count]), where)
    yield from (fold for fold in make_folds(plan, corpus) if fold.name in ("words2", "phones"))


def predictions(plan: Plan, corpus: Corpus, fold: Fold, members: tuple[str, ...]) -> dict[str, Modes]:
    """Modes of all clips that a fold measures, end to end, by member."""
    from phonanim.regressors import make_config, regressor_class

    face, found = reference_face(plan.corpus, fold.face_clips), {}
    shuffled = np.random.default_rng(1).permutation(fold.train)
    count = round(HELD_OUT * len(shuffled))
    held_out, rest = (
        make_examples(corpus, face, np.sort(part)) for part in (shuffled[:count], shuffled[count:])
    )
    for name in members:
        recipe, changes = MEMBERS[name]
        read = read_recipe(CONFIGS / f"{recipe}.toml")
        config = make_config(read.kind, {**(read.settings or {}), **changes}, recipe)
        regressor = regressor_class(read.kind).fit(
            config, rest, held_out, np.random.default_rng(1), lambda done: None
        )
        clips = fold.test.tolist()
        found[name] = np.concatenate([regressor.predict(corpus.tracks[c], corpus.times(c)) for c in clips])
    return found


def report(plan: Plan, corpus: Corpus, fold: Fold, name: str, modes: Modes) -> None:
    """Print the shape MSE, aperture r and width r of some modes."""
    face, ends = reference_face(plan.corpus, fold.face_clips), np.cumsum(corpus.frames[fold.test])[:-1]
    for where, frames in fold.where.items():
        rows = [
            clip_scores(
                face.instance(part),
                corpus.landmarks[corpus.rows([clip])],
                face,
                corpus.tracks[clip],
                corpus.fps,
                frames(corpus, clip),
            )
            for clip, part in zip(fold.test.tolist(), np.split(modes, ends), strict=True)
        ]
        found = {
            m: measure_value(m, np.array([row[m] for row in rows]))
            for m in ("shape_mse", "aperture_r", "width_r")
        }
        told = "  ".join(f"{measure} {number:.4f}" for measure, number in found.items())
        print(f"{fold.name}/{where:<8} {name:<22} {told}", flush=True)


@click.command(help=__doc__)
@click.argument("plan", type=click.Path(exists=True, path_type=Path))
@click.option("--fold", "only", help="This one alone: validation, words2 or phones.")
@click.option(
    "--member",
    "members",
    multiple=True,
    type=click.Choice(tuple(MEMBERS)),
    help="This one alone; may be repeated.",
)
def main(plan: Path, only: str | None, members: tuple[str, ...]) -> None:
    use_one_thread()
    read = read_plan(plan)
    corpus = load_cached_corpus(read.corpus)
    for fold in settings_of_folds(read, corpus):
        if only not in (None, fold.name):
            continue
        found = predictions(read, corpus, fold, members or tuple(MEMBERS))
        mixed = {
            name: sum(share * found[m] for m, share in parts.items())
            for name, parts in MIXTURES.items()
            if set(parts) <= set(found)
        }
        for name, modes in {**found, **mixed}.items():
            report(read, corpus, fold, name, modes)
        if fold.name == "validation" and not members:
            report(read, corpus, fold, "least squares", least_squares(corpus, fold, read, found))
            fitted = found["lstm, triphones"]
            report(read, corpus, fold, "lstm, clips' offsets", without_offsets(corpus, fold, read, fitted))


def least_squares(corpus: Corpus, fold: Fold, plan: Plan, found: dict[str, Modes]) -> Modes:
    """The mixture that does best on these very clips: a bound, not a result."""
    from scipy.optimize import nnls

    captured = reference_face(plan.corpus, fold.face_clips).project(corpus.landmarks[corpus.rows(fold.test)])
    parts = list(found.values())
    shares = nnls(np.stack([part.ravel() for part in parts], axis=1), captured.ravel())[0]
    return np.asarray(sum(share * part for share, part in zip(shares, parts, strict=True)))


def without_offsets(corpus: Corpus, fold: Fold, plan: Plan, modes: Modes) -> Modes:
    """Modes with the mean error of every clip taken away: what no phone tells."""
    captured = reference_face(plan.corpus, fold.face_clips).project(corpus.landmarks[corpus.rows(fold.test)])
    lengths = corpus.frames[fold.test]
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    offsets = np.add.reduceat(modes - captured, starts, axis=0) / lengths[:, None]
    return np.asarray(modes - np.repeat(offsets, lengths, axis=0))


if __name__ == "__main__":
    main()
