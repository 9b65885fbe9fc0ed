"""The test clips with other audio: the loss in noise, with another voice, with automatic alignment.

Audio-driven models get the changed audio. Phone-driven models get the phones that pocketsphinx finds in it,
with the text of the clip or without. All are scored against the same capture, on the same frames and at the
labelled closures.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import metrics, regressors
from phonanim.comparison.degradations import babble_noise, mix_noise, shift_voice, white_noise
from phonanim.comparison.folds import all_frames, speech_frames
from phonanim.comparison.plan import Condition, Plan
from phonanim.comparison.scores import scores_by_frames
from phonanim.core.decode import DAMAGE, decode_list, read_json
from phonanim.core.files import make_folder_within, write_text
from phonanim.corpus.corpus import Corpus
from phonanim.encoders._cache import fingerprint
from phonanim.errors import AlignmentError, ModelError
from phonanim.face import contacts
from phonanim.face.model import FaceModel
from phonanim.media.audio import Sound, read_sound
from phonanim.speech.alignment import Alignment, Interval
from phonanim.speech.intervals import unpack_intervals
from phonanim.speech.language import to_phones
from phonanim.speech.phones import PhoneTrack, silent_track

VOICES = 6  # training clips that are mixed as babble
WHERE = {"all": all_frames, "speech": speech_frames}


@dataclass(frozen=True)
class ClipInput:
    """Input of models for one clip under a condition; `aligned`: whether the aligner found the text."""

    clip: int
    sound: Sound
    track: PhoneTrack
    aligned: bool


def clip_inputs(
    plan: Plan, corpus: Corpus, work: Path, progress: Callable[[float], None]
) -> dict[str, tuple[ClipInput, ...]]:
    """The test clips under every condition of a plan. Alignments are cached in `work`.

    Raises AudioError for a recording that cannot be read, OptionError for a word that is unknown to the
    aligner, MissingExtraError.
    """
    found: dict[str, tuple[ClipInput, ...]] = {}
    clips = corpus.clips_of("test").tolist()
    for name, condition in plan.conditions.items():
        found[name] = tuple(_take(condition, plan.seed, corpus, clip, work) for clip in clips)
        progress(len(found) / len(plan.conditions))
    return found


def _take(condition: Condition, seed: int, corpus: Corpus, clip: int, work: Path) -> ClipInput:
    sound = apply_condition(condition, seed, corpus, clip)
    text = " ".join(word.label for word in corpus.words[clip]) if condition.text else None
    track = align_clip(sound, text, corpus.clips[clip], make_folder_within(work / "alignments", work))
    return ClipInput(clip, sound, track or silent_track(sound.duration), track is not None)


def apply_condition(condition: Condition, seed: int, corpus: Corpus, clip: int) -> Sound:
    """The sound of a clip under a condition. The noise depends on the seed and the clip, not on the level."""
    sound, rng = read_sound(corpus.audio[clip]), np.random.default_rng([seed, clip])
    if condition.voice:
        sound = shift_voice(sound, condition.voice)
    if not condition.noise:
        return sound
    length = len(sound.samples)
    if condition.noise == "white":
        noise = white_noise(length, rng)
    else:
        others = rng.choice(corpus.clips_of("train"), VOICES)
        noise = babble_noise([read_sound(corpus.audio[other]) for other in others], length, sound.rate, rng)
    spoken = metrics.speech_mask(corpus.tracks[clip], np.arange(length) / sound.rate)
    return mix_noise(sound, noise, condition.snr, spoken)


def align_clip(sound: Sound, text: str | None, name: str, folder: Path) -> PhoneTrack | None:
    """The phones of a sound by pocketsphinx, cached in a folder; None when it finds none."""
    path = folder / f"{fingerprint(f'pocketsphinx, {text}', sound)}.json"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        write_text(path, json.dumps(_phones(sound, text, name)) + "\n")
    phones = _read_phones(path)
    if not phones:
        return None
    return to_phones(Alignment(phones, sound.duration, "phones", name), "english")[0]


def _read_phones(path: Path) -> tuple[Interval, ...]:
    """The phones of a cached alignment. Raises ModelError."""
    try:
        return unpack_intervals(decode_list(read_json(path), "an alignment"))
    except (OSError, *DAMAGE) as error:
        raise ModelError(
            f"{path}: is a damaged alignment ({error}); delete it, and it is made again"
        ) from error


def _phones(sound: Sound, text: str | None, name: str) -> list[tuple[str, float, float]]:
    from phonanim.aligners import pocketsphinx as aligner

    try:
        found = aligner.align_sound(sound, text, name)
    except AlignmentError:
        return []
    return [(phone.label, phone.start, phone.end) for phone in found.phones]


def condition_scores(
    model: regressors.Model, inputs: dict[str, tuple[ClipInput, ...]], corpus: Corpus, face: FaceModel
) -> dict[str, dict[str, Any]]:
    """Sums of a model by variant and "with CONDITION/frames"; closures are those of the labelled phones."""
    found: dict[str, dict[str, Any]] = {"raw": {}, "contacts": {}}
    for name, given in inputs.items():
        modes = [_predict(model, take, corpus) for take in given]
        for variant, rows in found.items():
            shapes = _shapes(model, given, modes, corpus, closing=variant == "contacts")
            rows |= scores_by_frames(f"with {name}", shapes, WHERE, corpus, face)
    return found


def _predict(model: regressors.Model, take: ClipInput, corpus: Corpus) -> NDArray[np.float32]:
    return model.regressor.predict(take.track, corpus.times(take.clip), take.sound)


def _shapes(
    model: regressors.Model,
    given: tuple[ClipInput, ...],
    modes: list[NDArray[np.float32]],
    corpus: Corpus,
    closing: bool,
) -> Iterable[tuple[int, NDArray[np.floating]]]:
    for take, path in zip(given, modes, strict=True):
        if closing:
            path = contacts.enforce_lip_contacts(path, take.track, model.face, corpus.times(take.clip))
        yield take.clip, model.face.instance(path)


def describe_conditions(
    plan: Plan, inputs: dict[str, tuple[ClipInput, ...]], corpus: Corpus
) -> dict[str, dict[str, Any]]:
    """Description of each condition, clips that were not aligned, and speech frames with another phone."""
    return {
        name: {
            **asdict(plan.conditions[name]),
            "clips": len(given),
            "not_aligned": sum(not take.aligned for take in given),
            "other_phone": round(float(np.concatenate([_other(t, corpus) for t in given]).mean()), 4),
        }
        for name, given in inputs.items()
    }


def _other(take: ClipInput, corpus: Corpus) -> NDArray[np.bool_]:
    """Whether each frame of speech has another phone than the label."""
    times = corpus.times(take.clip)[speech_frames(corpus, take.clip)]
    return np.asarray(take.track.sample(times) != corpus.tracks[take.clip].sample(times))
