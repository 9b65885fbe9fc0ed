"""Visemes read from rigs of few shapes beside ARKit's: the default model, shown on the shipped head.

    phonanim corpus build RECORDINGS -o work/corpus
    python benchmarks/legibility_rigs.py work/corpus --ema RECORDINGS/ema_de --ema RECORDINGS/ema_en

The test clips are read by the shipped reader of lips, the sentences of sensors by readers that learned from
the sensors of all other sentences. Targets are the shipped ones, so that the rigs differ in nothing else.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from legibility import interval
from legibility_mouths import Curves, Line, pooled
from legibility_sensors import SENSED, SENSOR_RIDGE, sight_of

from phonanim.articulation.blend import blend_articulation
from phonanim.comparison.tables import markdown
from phonanim.corpus.corpus import load_corpus
from phonanim.ema.channels import load_recordings
from phonanim.evaluation.channels import CHANNEL_OF
from phonanim.evaluation.legibility import Reading, fit_reader, load_reader, read_visemes, see_lips
from phonanim.evaluation.surfaces import landmark_lips
from phonanim.face import contacts
from phonanim.pipeline import load_model
from phonanim.regressors import Model
from phonanim.rig import Rig, load_rig
from phonanim.rig.own_head import own_head
from phonanim.rig.retarget import retarget
from phonanim.rig.shown_mouth import show_mouth


def shown(model: Model, line: Line, rig: Rig) -> Curves:
    """What a rig shows of a line on its head, (frames,) mm by channel."""
    face, closed = model.face, contacts.closed_shape(model.face)
    modes = model.regressor.predict(line.track, line.times, None).astype(np.float32)
    modes = contacts.enforce_lip_contacts(modes, line.track, face, line.times)
    mouth = blend_articulation(face.instance(modes), face, closed, line.track, line.times)
    values = retarget(modes, face, rig, "auto", line.track, line.times, articulation=mouth)
    found, seen = own_head(rig), show_mouth(rig, values, face)
    assert found is not None
    assert seen is not None
    head, spots = found
    moved = np.tensordot(head.weights(values, rig.controls), spots.of(head.deltas), axes=1)
    lips = landmark_lips(1000 * (spots.of(head.vertices) + moved), spots.numbers)
    return {CHANNEL_OF[name]: curve for name, curve in lips.items()} | {"jaw": seen["jaw"]}


def film_readings(model: Model, corpus_folder: Path, rig: Rig) -> list[Reading]:
    """The visemes of each test clip, read by the shipped reader."""
    corpus, found = load_corpus(corpus_folder), []
    for clip in corpus.clips_of("test").tolist():
        line = Line(corpus.tracks[clip], corpus.times(clip), None)
        curves = shown(model, line, rig)
        seen = {lip: curves[channel] for lip, channel in CHANNEL_OF.items()}
        found.append(read_visemes(see_lips(seen, line.times, line.track), load_reader()))
    return found


def sensor_readings(model: Model, folders: tuple[Path, ...], rig: Rig) -> list[Reading]:
    """The visemes of each sentence of sensors, read by readers that did not learn from it."""
    recordings = [one for folder in folders for one in load_recordings(folder)]
    sights, found = [sight_of(one, one.curves) for one in recordings], []
    for number, one in enumerate(recordings):
        others = sights[:number] + sights[number + 1 :]
        curves = shown(model, Line(one.track, one.times, None), rig)
        found.append(read_visemes(sight_of(one, curves), fit_reader(others, SENSED, SENSOR_RIDGE)))
    return found


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, path_type=Path))
@click.option("--rig", "names", multiple=True, default=("arkit", "oculus15", "vrm"), help="Repeat.")
@click.option("--ema", "folders", multiple=True, type=click.Path(exists=True, path_type=Path))
def main(corpus: Path, names: tuple[str, ...], folders: tuple[Path, ...]) -> None:
    """Print the table."""
    model: Any = load_model("default")
    rows = [["rig", "visemes read right, this speaker", "others" if folders else ""]]
    for name in names:
        rig = load_rig(name)
        films = film_readings(model, corpus, rig)
        low, high = interval(films)
        sensed = f"{pooled(sensor_readings(model, folders, rig)).share():.0%}" if folders else ""
        rows.append([f"`{name}`", f"{pooled(films).share():.0%} [{low:.0%}, {high:.0%}]", sensed])
    print(markdown(rows))


if __name__ == "__main__":
    main()
