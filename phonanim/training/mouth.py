"""A rendered mouth: phones -> joint modes of shape and appearance -> pictures."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE, read_json, read_tensors
from phonanim.core.files import atomic_path, write_text
from phonanim.core.version import __version__
from phonanim.corpus.corpus import Corpus, load_corpus
from phonanim.corpus.pictures import Captured, joint_examples, load_captured
from phonanim.errors import ModelError
from phonanim.face.appearance import BACKDROP, AppearanceModel, load_appearance, save_appearance
from phonanim.media.audio import Sound, read_audio, resample
from phonanim.media.pixels import Image, draw_text
from phonanim.media.video import SOUND_RATE, write_film
from phonanim.regressors import Regressor, kind_of, make_config, regressor_class
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.labels import is_silent
from phonanim.speech.phones import PhoneTrack
from phonanim.training.recipe import Recipe, read_recipe
from phonanim.training.recipes import add_teacher_examples

CARD = "mouth.json"
LABEL, COLUMNS = 26, 12  # pixels below a picture of a strip, and pictures per row
INK = (236, 238, 242)

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Mouth:
    """A regressor whose modes are joint parameters, with the appearance model that renders them."""

    regressor: Regressor
    appearance: AppearanceModel
    card: dict[str, Any]

    def predict(
        self, track: PhoneTrack, times: NDArray[np.float64], sound: Sound | None = None
    ) -> NDArray[np.float32]:
        """Joint parameters at instants of a track, (times,) seconds -> (times, j)."""
        return self.regressor.predict(track, times, sound)

    def pictures(self, track: PhoneTrack, times: NDArray[np.float64], scale: float = 3.0) -> Image:
        """The mouth at instants of a track, (times,) seconds -> (times, rows, columns, 3)."""
        return self.appearance.render(self.predict(track, times), scale)


def train_mouth(config: Path, folder: Path, progress: Progress = lambda done: None) -> Path:
    """Train the mouth of a recipe on a corpus with its appearance model; returns its folder.

    The recipe is like that of any model (`read_recipe`). Raises ModelError or CorpusError.
    """
    recipe = read_recipe(config)
    corpus = load_corpus(config.parent / recipe.corpus)
    captured = load_captured(config.parent / recipe.corpus)
    save_mouth(fit_mouth(recipe, corpus, captured, config, progress), folder)
    return folder


def fit_mouth(
    recipe: Recipe, corpus: Corpus, captured: Captured, config: Path, progress: Progress = lambda done: None
) -> Mouth:
    """Train on the training clips of a corpus, as `training.fit_recipe` does."""
    kind = regressor_class(recipe.kind)
    if kind.input_modality != "phones":
        raise ModelError(
            f"{config}: a mouth is driven by phones, but {recipe.kind} uses audio; choose another kind"
        )
    rng = np.random.default_rng(recipe.seed)
    shuffled = rng.permutation(corpus.clips_of("train"))
    n_held_out = round(recipe.validation * len(shuffled))
    held_out = joint_examples(corpus, captured, np.sort(shuffled[:n_held_out]))
    recordings = joint_examples(corpus, captured, np.sort(shuffled[n_held_out:]))
    base = 0.5 if recipe.teacher else 0.0
    if recipe.teacher:
        recordings = add_teacher_examples(
            recordings, held_out, recipe.teacher, config, rng, lambda d: progress(base * d)
        )
    settings = make_config(recipe.kind, recipe.settings or {}, str(config))
    learned = kind.fit(settings, recordings, held_out, rng, lambda d: progress(base + (1 - base) * d))
    facts = {"tool": f"phonanim {__version__}", "corpus": corpus.provenance, "licence": recipe.licence}
    return Mouth(learned, captured.model, {"fps": corpus.fps, "seed": recipe.seed, **facts})


def save_mouth(mouth: Mouth, folder: Path) -> None:
    """Write a mouth: its appearance, joint.safetensors and, last, mouth.json."""
    from safetensors.numpy import save

    save_appearance(mouth.appearance, folder, {"licence": mouth.card["licence"]})
    with atomic_path(folder / "joint.safetensors") as path:
        tensors = mouth.regressor.tensors()
        path.write_bytes(save({name: np.ascontiguousarray(part) for name, part in tensors.items()}))
    facts = {
        "kind": kind_of(mouth.regressor),
        "config": asdict(mouth.regressor.config),
        "inventory": list(INVENTORY.phones),
    }
    write_text(folder / CARD, json.dumps(facts | mouth.card, indent=1) + "\n")


def load_mouth(folder: Path) -> Mouth:
    """Read the output of `save_mouth`. Raises ModelError when it is missing or damaged."""
    try:
        card = read_json(folder / CARD)
        if card["inventory"] != list(INVENTORY.phones):
            raise ValueError("made for another phone inventory")
        config = make_config(card["kind"], card["config"], str(folder / CARD))
        learned = regressor_class(card["kind"]).from_tensors(
            config, read_tensors(folder / "joint.safetensors")
        )
    except (OSError, *DAMAGE) as error:
        raise ModelError(
            f"{folder}: is not a mouth ({error}); make one with `phonanim mouth train`"
        ) from error
    return Mouth(learned, load_appearance(folder), card)


def strip(mouth: Mouth, track: PhoneTrack, scale: float = 2.0) -> Image:
    """A picture of the mouth in the middle of every phone except silence, with its label below."""
    middles = (track.bounds[:-1] + track.bounds[1:]) / 2
    spoken = [n for n, label in enumerate(track.labels) if not is_silent(label)]
    pictures = mouth.pictures(track, middles[spoken], scale)
    return label_pictures(pictures, [track.labels[n] for n in spoken])


def write_mouth_film(
    mouth: Mouth,
    track: PhoneTrack,
    path: Path,
    fps: float = 25.0,
    audio: Path | None = None,
    scale: float = 3.0,
    progress: Progress = lambda done: None,
) -> None:
    """Write a video of the mouth speaking a track, with its recording. Raises OutputError, AudioError."""
    times = np.arange(max(1, int(track.duration * fps))) / fps
    joint = mouth.predict(track, times)
    sound = resample(*read_audio(audio), SOUND_RATE) if audio else None

    def pictures() -> Iterator[Image]:
        for number in range(len(times)):
            yield mouth.appearance.render(joint[number : number + 1], scale)[0]
            progress((number + 1) / len(times))

    write_film(pictures(), path, Fraction(fps).limit_denominator(1001), sound)


def label_pictures(pictures: Image, labels: list[str]) -> Image:
    """Pictures (n, rows, columns, 3) side by side in rows of COLUMNS, with a label below each."""
    count, rows, columns = pictures.shape[:3]
    across = min(count, COLUMNS)
    sheet = np.empty((-(-count // across) * (rows + LABEL), across * columns, 3), np.uint8)
    sheet[:] = BACKDROP
    for place, (picture, label) in enumerate(zip(pictures, labels, strict=True)):
        row, column = divmod(place, across)
        top, left = row * (rows + LABEL), column * columns
        sheet[top : top + rows, left : left + columns] = picture
        draw_text(sheet, label, left + columns / 2, top + rows, INK, align=0.5)
    return sheet
