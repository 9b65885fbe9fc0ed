"""Styles and loudness on the shipped head: contacts are kept, whispers are not small, silence rests."""

from __future__ import annotations

import numpy as np
import pytest
from speech import track_of
from voices import RATE, TIMES, TRACK, voiced

from phonanim.animation.motion import Motion, predict_controls
from phonanim.articulation.styles import read_styles
from phonanim.face.model import FaceModel
from phonanim.media.voice import analyze_voice
from phonanim.options import Options
from phonanim.pipeline import load_cached_rig, load_model
from phonanim.rig.head import load_head
from phonanim.rig.landmark_rig import to_face_axes
from phonanim.rig.landmarks import shipped_landmarks
from phonanim.speech.inventory import INVENTORY
from phonanim.speech.loudness import Loudness, measure_loudness
from phonanim.speech.phones import PhoneTrack

LINE = track_of(
    "sil 0.5 m 0.06 aa 0.12 b 0.05 iy 0.1 f 0.08 aa 0.1 s 0.09 ow 0.14 "
    "p 0.04 ae 0.1 sh 0.1 uw 0.9 v 0.07 sil 0.5"
)
STYLES = sorted(read_styles())


def moved(track: PhoneTrack, options: Options, loudness: Loudness | None = None) -> Motion:
    frames = int(track.duration * 60)
    return predict_controls(
        track, load_model("default"), load_cached_rig("arkit"), options, frames, loudness=loudness
    )


def gap(motion: Motion) -> np.ndarray:
    """The gap of the head's inner lips, (frames,) mm."""
    face: FaceModel = load_model("default").face
    spots = shipped_landmarks()
    head = to_face_axes(load_head(), spots, face)
    at = {int(number): row for row, number in enumerate(spots.numbers)}
    lips = spots.of(head.shape(head.weights(motion.values, load_cached_rig("arkit").controls)))
    return np.asarray(lips[:, at[13], 1] - lips[:, at[14], 1])


def within(track: PhoneTrack, phones: list[str]) -> np.ndarray:
    """Frames in the middle of phones."""
    chosen = np.flatnonzero(np.isin(track.codes, INVENTORY.codes(phones)))
    middles = (track.bounds[chosen] + track.bounds[chosen + 1]) / 2
    return np.rint(middles * 60).astype(int)


@pytest.mark.parametrize("style", STYLES)
def test_contacts_are_kept_in_every_style(style: str) -> None:
    motion = moved(LINE, Options(**read_styles()[style]))
    assert motion.articulation is not None
    assert gap(motion)[within(LINE, ["p", "b", "m"])].max() <= 0.5
    assert motion.articulation.channel("lip_gap")[within(LINE, ["p", "b", "m"])].max() <= 0.0
    assert motion.articulation.channel("lower_lip_to_teeth")[within(LINE, ["f", "v"])].max() <= 1.0
    assert motion.articulation.channel("jaw")[within(LINE, ["s", "sh"])].max() <= 1.5


def test_styles_are_larger_and_smaller() -> None:
    opened = {}
    for style in ("mumbled", "casual", "neutral", "whispered", "clear", "shouted"):
        mouth = moved(LINE, Options(**read_styles()[style])).articulation
        assert mouth is not None
        opened[style] = mouth.channel("jaw")[within(LINE, ["aa"])].mean()
    assert opened["mumbled"] < opened["casual"] < opened["neutral"] < opened["clear"] < opened["shouted"]
    assert opened["whispered"] >= 0.98 * opened["neutral"]


def test_quick_mouths_get_further() -> None:
    slow, quick = (moved(LINE, Options(quickness=q)).articulation for q in (0.5, 2.0))
    assert slow is not None
    assert quick is not None
    assert np.ptp(quick.channel("jaw")) > np.ptp(slow.channel("jaw"))


def test_rounding_is_of_rounded_lips() -> None:
    plain, more = (moved(LINE, Options(rounding=r)).articulation for r in (1.0, 1.5))
    assert plain is not None
    assert more is not None
    round_, spread = within(LINE, ["uw"]), within(LINE, ["iy"])
    assert (more.channel("lip_width")[round_] < plain.channel("lip_width")[round_]).all()
    np.testing.assert_allclose(more.channel("lip_width")[spread], plain.channel("lip_width")[spread])
    np.testing.assert_allclose(more.channel("protrusion"), 1.5 * plain.channel("protrusion"))


def test_a_louder_phrase_opens_more_and_keeps_its_closures() -> None:
    sound = (voiced() * np.where(TIMES > 3.5, 2.0, 1.0)).astype(np.float32)
    loudness = measure_loudness(analyze_voice(sound, RATE), TRACK)
    even, followed = moved(TRACK, Options()), moved(TRACK, Options(), loudness)
    none = moved(TRACK, Options(loudness=0), loudness)
    np.testing.assert_array_equal(none.values, even.values)
    assert even.articulation is not None
    assert followed.articulation is not None
    open_ = within(TRACK, ["aa"])
    ratio = followed.articulation.channel("lip_gap")[open_] / even.articulation.channel("lip_gap")[open_]
    assert ratio[0] == pytest.approx(0.88, abs=0.03)
    assert ratio[-1] == pytest.approx(1.12, abs=0.03)
    np.testing.assert_array_equal(
        followed.articulation.channel("protrusion"), even.articulation.channel("protrusion")
    )
    assert gap(followed)[within(TRACK, ["m"])].max() <= 0.5


def test_silence_rests() -> None:
    for style in ("neutral", "shouted"):
        motion = moved(LINE, Options(**read_styles()[style]))
        assert motion.articulation is not None
        before = np.arange(60) / 60 < 0.45
        assert motion.articulation.channel("lip_gap")[:60][before].max() < 0.3
        np.testing.assert_allclose(motion.articulation.channel("jaw")[:60][before], 1.5, atol=0.1)
        assert gap(motion)[:60][before].max() < 0.5


def test_a_held_vowel_is_not_frozen() -> None:
    track = track_of("sil 0.3 m 0.1 aa 2.0 sil 0.3")
    open_ = slice(round(0.9 * 60), round(1.9 * 60))
    ranges = [np.ptp(moved(track, Options(hold=h)).articulation.channel("jaw")[open_]) for h in (0.0, 1.0)]  # type: ignore[union-attr]
    assert ranges[0] < 0.1
    assert 0.3 < ranges[1] < 3.0
