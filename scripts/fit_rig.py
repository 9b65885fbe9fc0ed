"""Fit the shipped presets to the reference face's motion, on the shipped head.

    python scripts/fit_rig.py                                      # the head has changed
    phonanim corpus build RECORDINGS -o work/corpus                # the reference face has
    python scripts/fit_rig.py work/corpus [--model NAME]

writes into lexicon/rigs: motion.csv (a sample of the training clips' motion); arkit and vrm (controls,
limits, mean, eight poses, direct map, measures of the mouth); oculus15.shapes.csv and oculus15.mouth.csv
(where each viseme takes the face and the mouth); and face, the reference face's own landmarks as a rig.
Without a corpus the sample of motion that is there serves. benchmarks/retarget.py gives the figures.
"""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.channels import CHANNELS
from phonanim.articulation.table import read_targets
from phonanim.core.catalog import DEFAULT_MODEL, find_model
from phonanim.core.files import write_text
from phonanim.core.lexicon import LEXICON
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.exporters._livelink import N_ARKIT, columns
from phonanim.face.fit import fit_face
from phonanim.face.model import FaceModel
from phonanim.pipeline import load_model
from phonanim.rig import HingeMap, Rig
from phonanim.rig.align import add_viseme_shapes
from phonanim.rig.fit import fit_rig
from phonanim.rig.head import Head, load_head
from phonanim.rig.landmark_rig import LandmarkRig, make_landmark_rig, to_face_axes
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.rig.measures import write_measures
from phonanim.rig.measuring import ARKIT, SHAPE, measure, mouth_effects, tongue_effects
from phonanim.rig.motion import SHIPPED, Motion, closed_face, read_motion, sample_motion, write_motion
from phonanim.rig.neck import TURNS
from phonanim.rig.tables import VRM, read_viseme_shapes, write_shapes
from phonanim.rig.tongue import CHANNELS as TONGUE_CHANNELS
from phonanim.rig.tongue import OPEN, Tongue, write_tongue
from phonanim.rig.write import write_rig
from phonanim.speech.gestures import GESTURES

JAW = "jawOpen"
# Where each shape of the tongue arrives at full weight: at the place of a gesture, seen in a channel.
ARRIVES = {
    "tongueBackUp": ("k", "tongue_body_height"),
    "tongueFrontUp": ("y", "tongue_body_height"),
    "tongueTipBack": ("r", "tongue_tip_front"),
    "tongueTipUp": ("t", "tongue_tip_height"),
}
EFFORT = 3.0  # mm² of a viseme at full weight
RIGS = LEXICON / "rigs"
FRAMES = 1000  # more change no figure in its second digit
# Sideways jaw and mouth are no speech; cheeks, nose and tongue do not show in the landmarks.
FARTHEST = {"headPitch": 60.0, "headYaw": 80.0, "headRoll": 45.0}  # degrees
STILL = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")
FITTED = (
    "bounded least squares of the shipped head's motion (MakeHuman, CC0) against speaker s1 of the GRID "
    "corpus (Cooke, Barker, Cunningham, Shao 2006, CC BY 4.0), 888 training clips; scripts/fit_rig.py."
)


def main() -> None:
    """Sample the motion, fit every preset, write them."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("corpus", type=Path, nargs="?")
    options.add_argument("--model", help="take the reference face of this model, not a new one")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    face, motion = sampled(chosen) if chosen.corpus else (load_model(DEFAULT_MODEL).face, read_motion())
    if chosen.corpus:
        write_motion(SHIPPED, motion)
    modes, head, spots = motion.modes(face), load_head(), shipped_landmarks()
    landmark_rig = make_landmark_rig(head, spots, face)
    preset = replace(arkit(tuple(sorted(columns()[:N_ARKIT]))), mouth=measure(head, spots, face, ARKIT))
    write_rig(RIGS / "arkit.toml", fit_rig(preset, landmark_rig, face, modes))
    write_tongues(to_face_axes(head, spots, face))
    visemes, shapes = viseme_landmark_rig(landmark_rig), add_viseme_shapes(head)
    mouth = measure(shapes, spots, face, dict.fromkeys(VRM, (SHAPE, EFFORT)))
    write_rig(RIGS / "vrm.toml", fit_rig(replace(vrm(), mouth=mouth), vrm_landmark_rig(visemes), face, modes))
    write_oculus(visemes, face, closed_face(face, modes))
    own = [f"viseme_{name}" for name in visemes.controls]
    mouth = measure(shapes, spots, face, dict.fromkeys(own, (SHAPE, EFFORT)))
    write_measures(RIGS / "oculus15.mouth.csv", mouth)
    if chosen.corpus:
        write_rig(RIGS / "face.toml", identity(face, closed_face(face, modes)))


def sampled(chosen: argparse.Namespace) -> tuple[FaceModel, Motion]:
    """The reference face of a model or of the corpus, and a sample of the corpus' motion in its modes."""
    corpus = load_corpus(chosen.corpus)
    face = load_model(chosen.model).face if chosen.model else train_face(corpus)
    shapes = corpus.landmarks[corpus.rows(corpus.clips_of("train"))]
    return face, sample_motion(face.project(shapes), face, FRAMES, np.random.default_rng(chosen.seed))


def train_face(corpus: Corpus) -> FaceModel:
    """The shape model of the training clips."""
    shipped = load_model(find_model(DEFAULT_MODEL)).face
    return fit_face(corpus.landmarks[corpus.rows(corpus.clips_of("train"))], corpus.indices, known=shipped)


def blank(name: str, title: str, source: str, controls: tuple[str, ...]) -> Rig:
    """Controls from 0 to 1 that rest at 0."""
    zeros, ones = np.zeros(len(controls)), np.ones(len(controls))
    empty = np.zeros((0, len(controls)))
    return Rig(name, title, source, controls, zeros, ones, zeros, zeros, empty, speech=controls)


def arkit(controls: tuple[str, ...]) -> Rig:
    """The ARKit controls, not yet fitted."""
    source = f"Control names: Apple ARKit, ARFaceAnchor.BlendShapeLocation. Poses and direct map: {FITTED}"
    title = "Apple ARKit, 52 blendshapes and the turns of the head"
    rig = blank("arkit", title, source, (*controls, *TURNS))
    farthest = np.array([FARTHEST[name] for name in TURNS])
    return replace(
        rig,
        minimum=np.append(rig.minimum[: -len(TURNS)], -farthest),
        maximum=np.append(rig.maximum[: -len(TURNS)], farthest),
        speech=tuple(name for name in controls if name.startswith(("jaw", "mouth")) and name not in STILL),
        at_most=((controls.index("mouthClose"), controls.index("jawOpen")),),
        head=RIGS / "head.glb",
        landmarks=RIGS / "arkit.landmarks.csv",
        accents=RIGS / "arkit.accents.csv",
        tongue=RIGS / "arkit.tongue.csv",
    )


def write_tongues(head: Head) -> None:
    """The tables of the shipped head's tongue, in the axes and size of the reference face.

    Each shape arrives at its place at full weight with the jaw open by OPEN, so that its way is as long as
    that of the gesture that is made there.
    """
    effects, rest = tongue_effects(head), read_targets().target[GESTURES.names.index("sil"), 0]
    assert effects is not None
    opening = effects[head.targets.index(JAW)]
    at_rest = rest / -mouth_effects(head, shipped_landmarks())[0][head.targets.index(JAW), 0]
    rows = [(JAW, "jaw", abs(at_rest), 0.0, opening), ("tongueTipForward", "dental", 1.0, 0.0, np.zeros(4))]
    for name, (gesture, channel) in ARRIVES.items():
        place = CHANNELS.index(channel)
        own, column = effects[head.targets.index(name)], TONGUE_CHANNELS.index(channel)
        target = read_targets().target[GESTURES.names.index(gesture), place]
        way = target - (OPEN - abs(at_rest)) * opening[column]
        rows.append((name, "free", 0.0, 0.0, own * way / own[column]))
    _write_tongue(RIGS / "arkit_tongue.tongue.csv", rows)
    _write_tongue(RIGS / "arkit.tongue.csv", [rows[0], ("tongueOut", "dental", 0.4, 0.2, np.zeros(4))])


def _write_tongue(path: Path, rows: list[tuple[str, str, float, float, NDArray[np.float64]]]) -> None:
    names, uses, amounts, shut, moved = zip(*rows, strict=True)
    table = Tongue(np.arange(len(names)), uses, np.array(amounts), np.array(shut), np.array(moved))
    write_tongue(path, table, names)


def vrm() -> Rig:
    """The VRM mouth expressions, not yet fitted."""
    source = (
        "Control names: VRM 1.0 expression presets. Shapes: viseme_shapes.csv on the shipped head. "
        f"Poses and direct map: {FITTED}"
    )
    return blank("vrm", "VRM, five mouth expressions", source, tuple(VRM))


def viseme_landmark_rig(landmark_rig: LandmarkRig) -> LandmarkRig:
    """The shipped head with visemes for controls, as viseme_shapes.csv mixes them of ARKit controls."""
    names, mixtures = read_viseme_shapes(landmark_rig.controls)
    return LandmarkRig(names, landmark_rig.rest, np.tensordot(mixtures, landmark_rig.shapes, axes=1))


def vrm_landmark_rig(visemes: LandmarkRig) -> LandmarkRig:
    """The five VRM expressions as the visemes that they stand for."""
    return replace(visemes.take(tuple(VRM.values())), controls=tuple(VRM))


def write_oculus(visemes: LandmarkRig, face: FaceModel, closed: NDArray[np.float64]) -> None:
    """Say where each Oculus viseme takes the face; silence is the face with its lips closed."""
    path = RIGS / "oculus15.toml"
    text = re.sub(r'(?m)^face = ".*"$', f'face = "{face.id}"', path.read_text(encoding="utf-8"))
    write_text(path, text)
    controls = tuple(re.findall(r"(?m)^(viseme_\w+) =", text))
    moved = [
        visemes.shapes[visemes.controls.index(name)] if name in visemes.controls else np.zeros_like(closed)
        for name in (control.removeprefix("viseme_") for control in controls)
    ]
    write_shapes(path.with_suffix(".shapes.csv"), face.project(closed + np.array(moved)) / face.std, controls)


def identity(face: FaceModel, closed: NDArray[np.float64]) -> Rig:
    """The reference face itself: three controls per landmark, in millimetres."""
    controls = tuple(f"landmark{number}_{axis}" for number in face.indices for axis in "xyz")
    halves = np.eye(len(face.std))
    slopes = (face.modes * face.std[:, None, None]).reshape(len(halves), -1)
    names = tuple(f"mode{k + 1}{sign}" for sign in "+-" for k in range(len(halves)))
    direct = HingeMap(
        names,
        np.concatenate([halves, -halves]),
        np.zeros(len(names)),
        np.concatenate([slopes, -slopes]),
        face.mean.ravel(),
    )
    source = (
        "The landmarks are MediaPipe's face mesh numbers, in millimetres; the map is the shape model itself."
    )
    reach = np.full(len(controls), 300.0)
    return replace(
        blank("face", "The reference face's own landmarks", source, controls),
        minimum=-reach,
        maximum=reach,
        rest=closed.ravel(),
        direct=direct,
        face=face.id,
    )


if __name__ == "__main__":
    main()
