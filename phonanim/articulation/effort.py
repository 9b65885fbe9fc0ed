"""How strongly a line is spoken: gains over time by stress, rate, loudness and held vowels.

Each gain is a factor around 1 of a channel's distance from rest. `scale_articulation` applies it and keeps
contacts. Stress: stressed vowels open the jaw more (Erickson and Kawahara 2016, Linguistics Vanguard 2).
Rate: fast speech reduces the jaw more than the lips (benchmarks/effort.py). Loudness: lip aperture and jaw
grow by about 4 % per dB; protrusion does not change.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from phonanim.articulation.trajectories import local_sums
from phonanim.speech.inventory import INVENTORY, SILENCE
from phonanim.speech.phones import PhoneTrack
from phonanim.speech.prosody import VOWELS, eased, stress

Array = NDArray[np.float64]

PER_DECIBEL = 0.04  # of jaw and lip gap: 0.034, 0.041 and 0.047 in three speakers
STRESSED = 0.04  # of jaw and lip gap, more in stressed vowels and less in unstressed ones
STRESS_SIGMA = 0.04  # seconds over which stress spreads
USUAL = 4.2  # syllables a second at which nothing changes: the mean of read English (LJSpeech)
JAW_RATE, LIP_RATE = 0.12, 0.05  # exponents of the rate, the best for eight sentences of sensors
RATE_SIGMA = 0.18  # seconds; 0.72 on either side have an influence
PAUSING = 0.1  # weight of the usual rate, so that the rate returns to it in pauses
RATES = 2.0, 9.0  # syllables a second; the rate is clipped to this range
HELD = 0.6  # seconds after which a vowel counts as held
BREATHING = 0.07  # of jaw and lip gap, up and down in a held vowel
WAVES = (0.7, 1.0), (1.13, 0.5)  # hertz and share: two waves without a common period, so that nothing repeats
SETTLING = 0.3  # seconds in which the variation of a held vowel fades in and out
SILENT = INVENTORY.code(SILENCE)


def effort_gains(
    track: PhoneTrack, times: Array, reduction: float = 1.0, hold: float = 1.0, decibels: Array | None = None
) -> dict[str, Array]:
    """Factors of jaw, lip gap and upper lip at rising instants, (frames,) seconds -> (frames,) each.

    `reduction` scales the effect of stress and rate, `hold` the variation of a held vowel. `decibels`
    (frames,) is the level of the speech above its usual level, from `phonanim.speech.loudness`.
    """
    common = np.ones(len(times)) if decibels is None else 1 + PER_DECIBEL * decibels
    common *= 1 + hold * held_variation(track, times)
    common *= np.maximum(1 + reduction * STRESSED * stress_curve(track, times), 0.0)
    faster = np.log(syllable_rate(track, times) / USUAL)
    jaw, lips = (common * np.exp(-reduction * power * faster) for power in (JAW_RATE, LIP_RATE))
    return {"jaw": jaw, "lip_gap": lips, "upper_lip": lips}


def stress_curve(track: PhoneTrack, times: Array) -> Array:
    """Stress over time, (frames,): 1 in stressed vowels, 0.5 in secondary stress, -1 in unstressed ones.

    0 where no stress is marked. A mark on consonants applies to the next vowel.
    """
    marks = vowel_stress(track)
    known = np.isfinite(marks)
    values = np.where(known, np.where(marks == 0, -1.0, marks), 0.0)
    return local_sums(track.bounds, values[None], times, STRESS_SIGMA)[0]


def vowel_stress(track: PhoneTrack) -> Array:
    """The stress of each segment, (segments,): for vowels as in `speech.prosody.stress`, else NaN."""
    marks = list(map(stress, track.labels))
    vowels = VOWELS[track.codes]
    known = np.isfinite(marks)
    found = np.full(len(marks), np.nan)
    if not known.any():
        return found
    before = np.nan
    for number in np.flatnonzero(vowels | known | (track.codes == SILENT)).tolist():
        if vowels[number]:
            found[number] = marks[number] if known[number] else before
        before = np.nan if vowels[number] else marks[number]
    return found


def syllable_rate(track: PhoneTrack, times: Array) -> Array:
    """Syllables a second of the speech around each instant, (frames,); pauses do not count.

    It is USUAL where there is no speech near.
    """
    spoken = track.codes != SILENT
    each = VOWELS[track.codes] / np.diff(track.bounds)
    count, weight = local_sums(track.bounds, np.stack([each, spoken]), times, RATE_SIGMA)
    rate = (count + PAUSING * USUAL) / (weight + PAUSING)
    return np.clip(rate, *RATES)


def held_variation(track: PhoneTrack, times: Array) -> Array:
    """A slow variation within held vowels, (frames,) around 0: a motionless mouth looks frozen."""
    total = np.zeros(len(times))
    held = VOWELS[track.codes] & (np.diff(track.bounds) > HELD)
    for begin, end in zip(track.bounds[:-1][held], track.bounds[1:][held], strict=True):
        rows = slice(*np.searchsorted(times, [begin, end]))
        near = times[rows] - begin
        wave = sum(share * np.sin(2 * np.pi * pace * near) for pace, share in WAVES)
        total[rows] = BREATHING * wave * eased(near / SETTLING) * eased((end - times[rows]) / SETTLING)
    return total
