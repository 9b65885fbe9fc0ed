"""Jaw and tongue against articulography: predicted heights and measured ones, over the speech of utterances.

    python benchmarks/ema.py RECORDINGS/ema_de --model tree=work/tree --json work/ema.json

The jaw is the chin of the reference face. The tongue is the shipped head's, where rig `arkit_tongue` moves
it by place of articulation, at three points of its upper side as far behind its tip as the sensors are.
Beside it stands the same tongue with rig `arkit`, which rides on the jaw alone: what is more comes from the
places.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.comparison.ema import ema_modes
from phonanim.core.files import write_text
from phonanim.ema import Utterance, load_utterances
from phonanim.metrics import correlation, lag
from phonanim.pipeline import load_model
from phonanim.rig import load_rig
from phonanim.rig.head import Head, load_head
from phonanim.rig.retarget import retarget

Array = NDArray[np.float64]
CHIN = 152  # MediaPipe's number
BEHIND = {"TT": 6.0, "TB": 24.0, "TD": 43.0}  # mm; sensors lie 18 and 37 mm behind that of the tip
REACH = 0.1  # seconds that a prediction may be shifted
RIGS = {"tongue": "arkit_tongue", "riding": "arkit"}


def upper_side(head: Head) -> dict[str, int]:
    """The vertices of the tongue's upper midline that are nearest to where the sensors are."""
    points = head.vertices[head.parts["tongue"]] * 1000  # mm
    facing = _normals(head)[head.parts["tongue"], 1] > 0
    behind = points[:, 2].max() - points[:, 2]
    middle = (np.abs(points[:, 0]) < 0.5) & facing
    return {
        name: head.parts["tongue"].start + int(np.argmin(np.where(middle, np.abs(behind - at), np.inf)))
        for name, at in BEHIND.items()
    }


def _normals(head: Head) -> Array:
    corners = head.vertices[head.triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(head.vertices)
    for corner in range(3):
        np.add.at(normals, head.triangles[:, corner], faces)
    return normals


def heights(model: regressors.Model, utterance: Utterance, head: Head) -> dict[str, Array]:
    """Predicted heights in mm, (samples,): the jaw, and three points of the tongue for each rig."""
    modes = ema_modes(model, utterance, closing=True)
    found = {"jaw": model.face.instance(modes)[:, model.face.landmark(CHIN), 1]}
    for how, name in RIGS.items():
        rig = load_rig(name)
        values = retarget(modes, model.face, rig, "auto", utterance.track, utterance.times)
        weights = head.weights(values, rig.controls)
        for sensor, vertex in upper_side(head).items():
            moved = weights @ head.deltas[:, vertex, 1]
            found[f"{how}_{sensor}"] = 1000 * (head.vertices[vertex, 1] + moved)
    return found


def scores(model: regressors.Model, utterance: Utterance, head: Head) -> dict[str, dict[str, float]]:
    """R over speech, the delay (ms; positive: the prediction is late) at which r is greatest, and that r."""
    rows: dict[str, dict[str, float]] = {}
    for name, predicted in heights(model, utterance, head).items():
        sensor = "LI" if name == "jaw" else name.rpartition("_")[2]
        measured = utterance.articulation.sensor(sensor)[utterance.speech, 2]
        curve = predicted[utterance.speech]
        delay, best = lag(curve, measured, utterance.fps, REACH)
        rows[name] = {"r": correlation(curve, measured), "lag_ms": 1000 * delay, "best_r": best}
    return rows


def row(label: str, found: dict[str, dict[str, dict[str, float]]], measures: list[str]) -> str:
    """A row of the table: r and the delay of each utterance."""
    cells = []
    for measure in measures:
        each = [one[measure] for one in found.values()]
        told = ", ".join("{r:.2f}".format(**one) for one in each)
        cells.append(f"{told} ({', '.join('{lag_ms:+.0f}'.format(**one) for one in each)} ms)")
    return f"| {label} | {' | '.join(cells)} |"


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--model", "models", multiple=True, help="NAME=FOLDER of a trained model.")
@click.option("--json", "output", type=click.Path(path_type=Path), help="Write every score.")
def main(folder: Path, models: tuple[str, ...], output: Path | None) -> None:
    """The shipped model, and others."""
    head, utterances = load_head(), load_utterances(folder)
    chosen = {"default": load_model("default")}
    chosen |= {name: regressors.load(Path(path)) for name, _, path in (m.partition("=") for m in models)}
    results: dict[str, Any] = {}
    print("| model | jaw | tongue tip | tongue middle | tongue back |\n|---|---|---|---|---|")
    for name, model in chosen.items():
        results[name] = {one.name: scores(model, one, head) for one in utterances}
        print(row(name, results[name], ["jaw", *(f"tongue_{sensor}" for sensor in BEHIND)]), flush=True)
        print(row(f"{name}, tongue riding", results[name], ["jaw", *(f"riding_{s}" for s in BEHIND)]))
    if output:
        write_text(output, json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
