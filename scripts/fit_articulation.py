"""Fit the targets of lexicon/articulation.csv to articulography and to the recorded lips, and write them.

    phonanim corpus build RECORDINGS -o work/corpus
    python scripts/fit_articulation.py work/corpus RECORDINGS/ema_de RECORDINGS/ema_en

Where recordings say little, targets stay near scripts/articulation_prior.csv, made by hand. Sigma, lead and
how far a fit may go from the prior are chosen per channel on recordings that were left out, one sentence
and one speaker at a time. Then each channel is scaled to the amplitude of natural speech (`SPREADS`).
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from articulation_data import FILMED, Array, lip_observations, observations

from phonanim.articulation import CHANNELS
from phonanim.articulation.fitting import Channel, Freedom, Observation, fit_channel
from phonanim.articulation.table import CHANNELS_FILE, TARGETS_FILE, Targets, read_targets
from phonanim.core.files import write_text
from phonanim.ema.channels import Recording, load_recordings
from phonanim.speech.gestures import GESTURES

HERE = Path(__file__).parent
PRIOR = HERE / "articulation_prior.csv"
RULED = "lower_lip_to_teeth"  # no sensor shows it
SHOWN = 2.0  # mm of the upper incisors that lips at rest show when they part
NEAR = 1.5  # mm, the least distance of a lip that does not touch them
OPTIONS = {
    "sigma": (0.022, 0.026, 0.03, 0.036, 0.043, 0.05, 0.06),
    "lead": (0.0, 0.03, 0.06),
    "target": (0.25, 0.5, 1.0, 2.0),
    "weight": (0.05, 0.3, 0.6),
}
ROUNDING = ("lip_width", "protrusion")  # channels whose rounded gestures may begin early
START = {"sigma": 0.036, "lead": 0.0, "target": 1.0, "weight": 0.3}
CLIPS_OF_SEARCH = 20
# Least weight of the rounded vowels and w: few sentences of sensors have them, and where the fit leaves them
# weak, neighbours flatten them.
RESISTING = {"lip_width": 0.2, "protrusion": 0.8}
# The same for sh and zh, which the recorded lips do not have, so that they are not as wide as s.
POSTALVEOLAR = {"lip_width": 0.8, "protrusion": 1.3}
PRICE = 0.01  # of r
ROUND = GESTURES.articulation[:, GESTURES.columns.index("rounding")] >= 0.5
# sd in speech, mm, beside those of the recordings given. First JW11, 43,260 frames of x-ray microbeam. Then
# Haskins M01 (two sentences) and the quietest and the loudest of three Mandarin speakers (5th to 95th
# percentile over 3.3), and for the width the median of seventeen speakers in films of natural talk.
SPREADS = {
    "jaw": (2.84, 1.25),
    "lip_gap": (5.2, 3.7, 2.7, 4.1),
    "lip_width": (3.7,),
    "protrusion": (2.1,),
    "upper_lip": (1.88,),
    "tongue_tip_height": (6.41,),
    "tongue_tip_front": (5.59,),
    "tongue_body_height": (4.33,),
    "tongue_body_front": (4.2,),
}


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, path_type=Path))
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option(
    "--keep",
    multiple=True,
    type=click.Choice(CHANNELS),
    help="Keep sigma, lead and freedom of a channel; repeat.",
)
def main(corpus: Path, folders: tuple[Path, ...], keep: tuple[str, ...]) -> None:
    """Search, fit, scale, write."""
    recordings = [one for folder in folders for one in load_recordings(folder)]
    prior, found, chosen = read_targets(PRIOR), {}, {}
    for number, name in enumerate(CHANNELS):
        if name == RULED:
            continue
        seen = observations(recordings, name)
        lips = lip_observations(corpus, name)
        start = Channel(prior.target[:, number], prior.weight[:, number], 0.0, 0.0)
        known = settings_of(CHANNELS_FILE)[name] if name in keep else None
        chosen[name] = known or search(name, seen + lips[:CLIPS_OF_SEARCH], start)
        fitted = fit(seen + lips, start, chosen[name])
        found[name] = scaled(name, fitted, recordings)
        click.echo(f"{name}: {chosen[name]}")
    write_tables(with_rule(found, prior), chosen)


def fit(seen: list[Observation], start: Channel, settings: dict[str, float]) -> Channel:
    """A fit with sigma, lead and freedom as given."""
    prior = replace(start, sigma=settings["sigma"], lead=settings["lead"])
    return fit_channel(seen, prior, Freedom(settings["target"], settings["weight"]))


def search(name: str, seen: list[Observation], start: Channel) -> dict[str, float]:
    """Settings that are best for recordings left out: one setting after another, twice.

    At the price of `PRICE` each, targets then stay nearer to phonetics, sigma is less, since sharp mouths
    are read better, and lead is more, since lips are known to round early.
    """
    best = dict(START)
    score = left_out(seen, start, best)
    for _ in range(2):
        for key in ("target", "sigma", *(("lead",) if name in ROUNDING else ()), "weight"):
            for value in OPTIONS[key]:
                tried = best | {key: value}
                reached = left_out(seen, start, tried)
                if reached > score + 1e-4:
                    best, score = tried, reached
    for key, wanted in (("target", min), ("sigma", min), ("lead", max)):
        if key != "lead" or name in ROUNDING:
            values = [v for v in OPTIONS[key] if left_out(seen, start, best | {key: v}) >= score - PRICE]
            best[key] = wanted([*values, best[key]])
            score = left_out(seen, start, best)
    return best


def left_out(seen: list[Observation], start: Channel, settings: dict[str, float]) -> float:
    """Mean correlation over sentences that were left out, alone and with all of their speaker's.

    Clips of the camera, the later half of them left out, count as one more sentence.
    """
    scores = []
    for kind, fitted, group in folds(seen, start, settings):
        found = [correlation(fitted, one) for one in group]
        scores += [float(np.mean(found))] if kind == "camera" else found
    return float(np.mean(scores))


def folds(
    seen: list[Observation], start: Channel, settings: dict[str, float]
) -> Iterator[tuple[str, Channel, list[Observation]]]:
    """Fits without some recordings, and what they left out, by kind.

    Each "sentence" of sensors, each "speaker" of sensors, and half of the clips of a "camera".
    """
    judges = [one for one in seen if one.share == 1]
    speakers = sorted({one.speaker for one in judges})
    groups = [("sentence", [one]) for one in judges]
    groups += [("speaker", [one for one in judges if one.speaker == speaker]) for speaker in speakers]
    filmed = [one for one in seen if one.share < 1]
    groups += [("camera", filmed[len(filmed) // 2 :])] if filmed else []
    for kind, group in groups:
        kept = [one for one in seen if all(one is not other for other in group)]
        yield kind, fit(kept, start, settings), group


def correlation(fitted: Channel, one: Observation) -> float:
    return float(np.corrcoef(fitted.predict(one.track, one.times), one.values)[0, 1])


def scaled(name: str, fitted: Channel, recordings: list[Recording]) -> Channel:
    """Targets scaled so that their sd over the recordings is that of a middling speaker.

    Teeth that meet and lips that touch stay where they are, others keep their mean. Rounded gestures have a
    least weight (RESISTING).
    """
    least = np.where(ROUND, RESISTING.get(name, 0.0), 0.0)
    for phone in ("sh", "zh"):  # ch and jh end in these
        least[GESTURES.names.index(phone)] = POSTALVEOLAR.get(name, 0.0)
    fitted = replace(fitted, weight=np.maximum(fitted.weight, least))
    blend = np.concatenate([fitted.predict(one.track, one.times[one.speech]) for one in recordings])
    kept = {"jaw": fitted.target[GESTURES.names.index("s")], "lip_gap": 0.0}.get(name, blend.mean())
    factor = amplitude(name, recordings) / blend.std()
    return replace(fitted, target=kept + factor * (fitted.target - kept))


def amplitude(name: str, recordings: list[Recording]) -> float:
    """Geometric mean over speakers of the sd in speech, mm."""
    by_speaker: dict[str, list[Array]] = {}
    for one in recordings:
        if one.in_mm and name in one.curves:
            curve = one.curves[name][one.speech]
            by_speaker.setdefault(one.speaker, []).append(curve - curve.mean())
    spreads = [float(np.concatenate(curves).std()) for curves in by_speaker.values()]
    return float(np.exp(np.mean(np.log([*spreads, *SPREADS[name]]))))


def with_rule(found: dict[str, Channel], prior: Targets) -> dict[str, Channel]:
    """Rest as it is by definition, and the lower lip's distance from the teeth from gap and upper lip."""
    silent, ruled = GESTURES.names.index("sil"), CHANNELS.index(RULED)
    for name, channel in found.items():
        channel.target[silent] = prior.target[silent, CHANNELS.index(name)]
    gap, lift = found["lip_gap"], found["upper_lip"].target
    target = np.maximum(NEAR, gap.target - SHOWN - np.maximum(lift, 0))
    touching = GESTURES.articulation[:, GESTURES.columns.index("lip_to_teeth")] > 0
    target[touching] = prior.target[touching, ruled]
    target[silent] = prior.target[silent, ruled]
    weight = np.where(touching, prior.weight[:, ruled], gap.weight)
    return found | {RULED: Channel(target, weight, gap.sigma, 0.0)}


def settings_of(path: Path) -> dict[str, dict[str, float]]:
    """What an earlier search chose, by channel."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = {row["channel"]: row for row in csv.DictReader(file) if row["target_freedom"]}
    return {
        name: {
            "sigma": float(row["sigma"]),
            "lead": float(row["lead"]),
            "target": float(row["target_freedom"]),
            "weight": float(row["weight_freedom"]),
        }
        for name, row in rows.items()
    }


def write_tables(found: dict[str, Channel], chosen: dict[str, dict[str, float]]) -> None:
    """Both tables of lexicon/, with the source of each row."""
    rows = [
        (gesture, name, f"{found[name].target[g]:.2f}", f"{found[name].weight[g]:.2f}", source(name, gesture))
        for g, gesture in enumerate(GESTURES.names)
        for name in CHANNELS
    ]
    write_csv(TARGETS_FILE, ("gesture", "channel", "target", "weight", "source"), rows)
    with CHANNELS_FILE.open(encoding="utf-8", newline="") as file:
        meanings = {row["channel"]: row["meaning"] for row in csv.DictReader(file)}
    timing = [
        (
            name,
            f"{found[name].sigma:g}",
            f"{found[name].lead:g}",
            *([f"{chosen[name][key]:g}" for key in ("target", "weight")] if name in chosen else ["", ""]),
            meanings[name],
            "as lip_gap" if name == RULED else "best of a grid on recordings left out (EMA)",
        )
        for name in CHANNELS
    ]
    header = ("channel", "sigma", "lead", "target_freedom", "weight_freedom", "meaning", "source")
    write_csv(CHANNELS_FILE, header, timing)


def source(name: str, gesture: str) -> str:
    if gesture == "sil":
        return "definition of rest; weight: by hand" if name == RULED else "definition of rest; weight: fit"
    if name == RULED:
        return "by hand" if gesture in ("f", "v") else "rule: lip_gap - 2 - upper_lip; weight: as lip_gap"
    lips = " and GRID s1" if name in FILMED else ""
    return f"fit: EMA (EMU demo, mngu0, HPRC F01){lips}; drawn to articulation_prior.csv"


def write_csv(path: Path, header: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows([header, *rows])
    write_text(path, stream.getvalue())


if __name__ == "__main__":
    main()
