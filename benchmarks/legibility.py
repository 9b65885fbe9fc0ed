"""Every kind of model with and without articulation: likeness to lips and sensors, and legibility.

    phonanim corpus build RECORDINGS -o work/corpus
    python benchmarks/legibility.py benchmarks/legibility.toml --work work/legibility \\
        --ema RECORDINGS/ema_de --ema RECORDINGS/ema_en -o docs/benchmark/legibility.json

Models that are not trained yet are trained first and kept in --work. "lips alone" is the learned face as it
was before articulation, with closures; "phones" blends it with articulation from phones, "sound" with
articulation from sound alone (audio-driven models of whole recordings). Readers of visemes: `lips` is the
shipped one, `sensors` one that learned jaw and lips from the sensors of all other sentences. For sensors,
targets are fitted anew without the sentence. Audio-driven models are compared
with the recordings that have sound.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
from legibility_mouths import ArticulationOf, Curves, Line, Mouth, head_lips, listener, mouths, pooled
from legibility_sensors import left_out_targets, sensor_rows

from phonanim.articulation.table import read_targets
from phonanim.comparison.fit import Job, fit_all, folder_name, load_trained
from phonanim.comparison.legibility import film_table, sensor_table
from phonanim.comparison.plan import Plan, read_plan
from phonanim.comparison.tables import markdown
from phonanim.core.files import write_text
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.ema import load_utterances
from phonanim.ema.channels import load_recordings
from phonanim.evaluation.channels import CHANNEL_OF
from phonanim.evaluation.legibility import Reading, load_reader, read_visemes, see_lips
from phonanim.evaluation.surfaces import landmark_lips
from phonanim.media.audio import read_sound
from phonanim.metrics import correlation, regression_slope, sd_ratio, speech_mask
from phonanim.regressors import Model

DRAWS = 1000  # of the bootstrap over clips


def film_rows(
    models: dict[str, Model], corpus: Corpus, articulation_of: ArticulationOf
) -> Iterator[dict[str, Any]]:
    """Each model and way against the captured lips of the test clips."""
    clips = corpus.clips_of("test").tolist()
    captured = [corpus.landmarks[corpus.rows([clip])].astype(np.float64) for clip in clips]
    wanted = [{CHANNEL_OF[k]: v for k, v in landmark_lips(one, corpus.indices).items()} for one in captured]
    yield {"model": "captured motion", "way": "", **scores_of(wanted, wanted, wanted, corpus, clips)}
    for name, model in models.items():
        found: dict[str, list[Mouth]] = {}
        for clip in clips:
            sound = None if model.regressor.input_modality == "phones" else read_sound(corpus.audio[clip])
            line = Line(corpus.tracks[clip], corpus.times(clip), sound)
            for way, mouth in mouths(model, line, articulation_of(model), read_targets()).items():
                found.setdefault(way, []).append(mouth)
        for way, each in found.items():
            heads = [{CHANNEL_OF[k]: v for k, v in head_lips(one.values).items()} for one in each]
            scores = scores_of([one.curves for one in each], heads, wanted, corpus, clips)
            yield {"model": name, "way": way, **scores}


def scores_of(
    curves: list[Curves], heads: list[Curves], wanted: list[Curves], corpus: Corpus, clips: list[int]
) -> dict[str, Any]:
    """Likeness of gap and width in speech, and visemes read, as predicted and on the head."""
    said = [speech_mask(corpus.tracks[clip], corpus.times(clip)) for clip in clips]
    row: dict[str, Any] = {}
    for name in ("lip_gap", "lip_width"):
        ours, theirs = (
            np.concatenate([one[name][mask] for one, mask in zip(side, said, strict=True)])
            for side in (curves, wanted)
        )
        row[f"{name}_r"] = correlation(ours, theirs)
        row[f"{name}_slope"], row[f"{name}_sd_ratio"] = regression_slope(ours, theirs), sd_ratio(ours, theirs)
    for label, side in (("legible", curves), ("legible_on_head", heads)):
        readings = []
        for one, clip in zip(side, clips, strict=True):
            seen = {lip: one[channel] for lip, channel in CHANNEL_OF.items()}
            readings.append(
                read_visemes(see_lips(seen, corpus.times(clip), corpus.tracks[clip]), load_reader())
            )
        row[label], row[f"{label}_interval"] = pooled(readings).share(), interval(readings)
        row[f"{label}_log_p"] = pooled(readings).log_probability()
    return row


def interval(readings: list[Reading]) -> list[float]:
    """95 % interval of the share read right when lines are drawn anew."""
    rng = np.random.default_rng(0)
    drawn = (rng.integers(0, len(readings), len(readings)) for _ in range(DRAWS))
    shares = [pooled([readings[i] for i in rows]).share() for rows in drawn]
    return [float(share) for share in np.percentile(shares, [2.5, 97.5])]


def load_models(plan: Plan, work: Path) -> dict[str, Model]:
    """The models of a plan; recipes are trained on the training clips where that was not done yet."""
    corpus = load_corpus(plan.corpus)
    train = tuple(corpus.clips_of("train").tolist())
    jobs = {
        name: Job(where, plan.corpus, train, train, work / folder_name(name) / "test")
        for name, where in plan.models.items()
        if where.is_file()
    }
    fit_all(list(jobs.values()), 1, lambda done: print(f"trained {done:.0%}", file=sys.stderr))
    folders = {name: jobs[name].folder if name in jobs else where for name, where in plan.models.items()}
    return {name: load_trained(folder).model for name, folder in folders.items()}


def rounded(value: Any) -> Any:
    """The same with numbers of four decimals."""
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    if isinstance(value, list):
        return [rounded(part) for part in value]
    return round(value, 4) if isinstance(value, float) else value


@click.command(help=__doc__)
@click.argument("plan_file", metavar="PLAN", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--work", type=click.Path(path_type=Path), default=Path("work/legibility"), show_default=True)
@click.option(
    "--ema", "folders", multiple=True, type=click.Path(exists=True, path_type=Path), help="Sensors."
)
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("work/legibility.json"))
def main(plan_file: Path, work: Path, folders: tuple[Path, ...], output: Path) -> None:
    """Train what is missing, score, write the JSON and print the tables."""
    plan = read_plan(plan_file)
    corpus, models = load_corpus(plan.corpus), load_models(plan, work)
    articulation_of = listener(corpus)
    found: dict[str, Any] = {"films": list(film_rows(models, corpus, articulation_of)), "sensors": []}
    recordings = [one for folder in folders for one in load_recordings(folder)]
    if recordings:
        bundles = [folder for folder in folders if not list(folder.glob("*.npz"))]
        spoken = [one for folder in bundles for one in load_utterances(folder)]
        sounds = {one.name: read_sound(one.audio) for one in spoken}
        targets = left_out_targets(recordings, plan.corpus)
        found["sensors"] = list(sensor_rows(models, recordings, sounds, articulation_of, targets))
    write_text(output, json.dumps(rounded(found), indent=1) + "\n")
    print(markdown(film_table(found)), markdown(sensor_table(found)), sep="\n\n")


if __name__ == "__main__":
    main()
