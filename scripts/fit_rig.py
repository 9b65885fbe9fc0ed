"""Fit the ARKit preset to the reference face's motion, on the shipped head.

    phonanim corpus build RECORDINGS -o work/corpus
    python scripts/fit_rig.py work/corpus [--model NAME]

writes lexicon/rigs/motion.csv (a sample of the training clips' motion), arkit.toml (controls, limits,
mean, eight poses) and arkit.direct.csv (the direct map). Run it again when the reference face or the head
changes; benchmarks/retarget.py gives the figures.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from phonanim.animate import load_model
from phonanim.corpus import load_corpus
from phonanim.face import fit_face
from phonanim.head import load_head
from phonanim.inventory import LEXICON
from phonanim.rig.fit import fit_rig
from phonanim.rig.landmarks import read_landmarks
from phonanim.rig.motion import SHIPPED, sample_motion, write_motion
from phonanim.rig.puppet import make_puppet
from phonanim.rig.rig import Rig
from phonanim.rig.write import write_rig

RIGS = LEXICON / "rigs"
FRAMES = 1000  # more change no figure in its second digit
# Sideways jaw and mouth are no speech; cheeks, nose and tongue do not show in the landmarks.
STILL = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")
SOURCE = (
    "Control names: Apple ARKit, ARFaceAnchor.BlendShapeLocation. Poses and direct map: bounded least "
    "squares of the shipped head's motion (MakeHuman, CC0) against speaker s1 of the GRID corpus (Cooke, "
    "Barker, Cunningham, Shao 2006, CC BY 4.0), 888 training clips; scripts/fit_rig.py."
)


def main() -> None:
    """Sample the motion, fit the rig, write both."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("corpus", type=Path)
    options.add_argument("--model", help="take the reference face of this model, not a new one")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    corpus = load_corpus(chosen.corpus)
    rows = corpus.rows(corpus.clips_of("train"))
    fitted = fit_face(corpus.landmarks[rows], corpus.indices)
    face = load_model(chosen.model).face if chosen.model else fitted
    rng = np.random.default_rng(chosen.seed)
    motion = sample_motion(face.project(corpus.landmarks[rows]), face, FRAMES, rng)
    write_motion(SHIPPED, motion)
    head = load_head()
    puppet = make_puppet(head, read_landmarks(RIGS / "arkit.landmarks.csv"), face)
    write_rig(RIGS / "arkit.toml", fit_rig(arkit(head.targets), puppet, face, motion.modes(face)))


def arkit(controls: tuple[str, ...]) -> Rig:
    """The ARKit controls, not yet fitted."""
    count = len(controls)
    return Rig(
        name="arkit",
        title="Apple ARKit, 52 blendshapes",
        source=SOURCE,
        controls=controls,
        minimum=np.zeros(count),
        maximum=np.ones(count),
        rest=np.zeros(count),
        mean=np.zeros(count),
        poses=np.zeros((0, count)),
        speech=tuple(name for name in controls if name.startswith(("jaw", "mouth")) and name not in STILL),
        at_most=((controls.index("mouthClose"), controls.index("jawOpen")),),
        head=RIGS / "head.glb",
        landmarks=RIGS / "arkit.landmarks.csv",
    )


if __name__ == "__main__":
    main()
