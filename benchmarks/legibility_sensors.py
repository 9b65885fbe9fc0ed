"""Models with and without articulation against sensors, and what readers of sensors read from them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from legibility_mouths import Array, ArticulationOf, Curves, Line, mouths, pooled

sys.path[:0] = [str(Path(__file__).parent.parent / "scripts")]

from articulation_data import lip_observations, observations  # noqa: E402
from fit_articulation import PRIOR, folds, scaled, settings_of  # noqa: E402

from phonanim.articulation import CHANNELS  # noqa: E402
from phonanim.articulation.fitting import Channel  # noqa: E402
from phonanim.articulation.table import CHANNELS_FILE, Targets, read_targets  # noqa: E402
from phonanim.ema.channels import Recording  # noqa: E402
from phonanim.evaluation.legibility import Reading, Sight, fit_reader, read_visemes, see_lips  # noqa: E402
from phonanim.media.audio import Sound  # noqa: E402
from phonanim.metrics import correlation, sd_ratio  # noqa: E402
from phonanim.regressors import Model  # noqa: E402

SENSED = ("jaw", "lip_gap", "protrusion", "upper_lip")
SENSOR_RIDGE = 0.2  # eight sentences are few examples


def sensor_rows(
    models: dict[str, Model],
    recordings: list[Recording],
    sounds: dict[str, Sound],
    articulation_of: ArticulationOf,
    targets: dict[str, Targets],
) -> Iterator[dict[str, Any]]:
    """Each model and way against sensors: r of jaw and gap, ratio of deviations in mm, and visemes read."""
    sights = [sight_of(one, one.curves) for one in recordings]
    readers = [
        fit_reader([s for j, s in enumerate(sights) if j != i], SENSED, SENSOR_RIDGE)
        for i in range(len(sights))
    ]
    groups = {"all sentences": recordings, "with sound": [one for one in recordings if one.name in sounds]}
    for group, chosen in groups.items():
        at = [recordings.index(one) for one in chosen]
        real = pooled([read_visemes(sights[i], readers[i]) for i in at])
        yield {
            "model": "sensors",
            "way": "",
            "group": group,
            "legible": real.share(),
            "phones": len(real.said),
        }
        for name, model in models.items():
            if group == "all sentences" and model.regressor.input_modality != "phones":
                continue
            found: dict[str, list[tuple[dict[str, float], Reading]]] = {}
            for i, one in zip(at, chosen, strict=True):
                line = Line(one.track, one.times, sounds.get(one.name))
                for way, mouth in mouths(model, line, articulation_of(model), targets[one.name]).items():
                    scores = sensor_scores(mouth.curves, one)
                    reading = read_visemes(sight_of(one, mouth.curves), readers[i])
                    found.setdefault(way, []).append((scores, reading))
            for way, each in found.items():
                keys = dict.fromkeys(key for scores, _ in each for key in scores)
                means = {k: float(np.mean([s[k] for s, _ in each if k in s])) for k in keys}
                share = pooled([reading for _, reading in each]).share()
                yield {"model": name, "way": way, "group": group, **means, "legible": share}


def sight_of(one: Recording, curves: Curves) -> Sight:
    """What a reader sees of the sensed channels in the speech of a recording."""
    rows = np.flatnonzero(one.speech)
    kept = slice(rows[0], rows[-1] + 1)
    held = {name: filled(curves[name][kept]) for name in SENSED}
    return see_lips(held, one.times[kept], one.track, SENSED, one.speech[kept])


def filled(curve: Array) -> Array:
    """Samples that were lost, straight between their neighbours."""
    known = np.isfinite(curve)
    return np.interp(np.arange(len(curve)), np.flatnonzero(known), curve[known])


def sensor_scores(curves: Curves, one: Recording) -> dict[str, float]:
    """R of each sensed channel, and the ratio of deviations where sensors are in mm."""
    found = {}
    for name in SENSED:
        pair = curves[name][one.speech], one.curves[name][one.speech]
        found[f"{name}_r"] = correlation(*pair)
        if one.in_mm:
            found[f"{name}_sd_ratio"] = sd_ratio(*pair)
    return found


def left_out_targets(recordings: list[Recording], corpus: Path) -> dict[str, Targets]:
    """Targets for each recording that were fitted without it; the channels that are not scored as shipped."""
    prior, settings, shipped = read_targets(PRIOR), settings_of(CHANNELS_FILE), read_targets()
    found = {one.name: shipped for one in recordings}
    for name in SENSED:
        number = CHANNELS.index(name)
        start = Channel(prior.target[:, number], prior.weight[:, number], 0.0, 0.0)
        seen = observations(recordings, name) + lip_observations(corpus, name)
        for kind, fitted, group in folds(seen, start, settings[name]):
            if kind != "sentence":
                continue
            for left in {one.name for one in group}:
                kept = [one for one in recordings if one.name != left]
                found[left] = with_channel(found[left], number, scaled(name, fitted, kept))
    return found


def with_channel(targets: Targets, number: int, fitted: Channel) -> Targets:
    """The targets with one channel replaced."""
    new = {"target": fitted.target, "weight": fitted.weight, "sigma": fitted.sigma, "lead": fitted.lead}
    parts = {name: getattr(targets, name).copy() for name in new}
    for name, value in new.items():
        parts[name][..., number] = value
    return replace(targets, **parts)
