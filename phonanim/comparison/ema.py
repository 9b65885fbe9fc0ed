"""Test on another speaker and language: lip aperture against the distance of sensors on real lips."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim import regressors
from phonanim.ema import Utterance, load_utterances
from phonanim.evaluation.statistics import pearson, pearson_sums
from phonanim.face import contacts
from phonanim.face.model import lip_aperture
from phonanim.media.audio import read_sound

LAGS = np.arange(-10, 11)  # samples of 5 ms at 200 Hz: 50 ms either way


def ema_scores(model: regressors.Model, folder: Path, closing: bool) -> dict[str, Any]:
    """Sums for Pearson's r of aperture over the speech of each utterance, and the lag (ms) of its best r.

    Silence is left out, because the lips of speakers at rest differ. A positive lag means a late prediction.
    """
    sums, lags = [], []
    for utterance in load_utterances(folder):
        aperture = lip_aperture(model.face.instance(ema_modes(model, utterance, closing)), model.face)
        sums.append(pearson_sums(aperture[utterance.speech], utterance.aperture[utterance.speech]).tolist())
        lags.append(_lag(aperture, utterance))
    return {"aperture_r": sums, "lag_ms": lags}


def ema_modes(model: regressors.Model, utterance: Utterance, closing: bool) -> NDArray[np.float32]:
    """Modes at the instants of the sensors, (samples, modes)."""
    sound = None if model.regressor.input_modality == "phones" else read_sound(utterance.audio)
    modes = model.regressor.predict(utterance.track, utterance.times, sound)
    if not closing:
        return modes
    return contacts.enforce_lip_contacts(modes, utterance.track, model.face, utterance.times)


def _lag(aperture: NDArray[np.float64], utterance: Utterance) -> float:
    rows = np.flatnonzero(utterance.speech)
    rows = rows[(rows >= LAGS.max()) & (rows < len(aperture) + LAGS.min())]
    found = [float(pearson(pearson_sums(aperture[rows + lag], utterance.aperture[rows]))) for lag in LAGS]
    return float(LAGS[int(np.argmax(found))] / utterance.fps * 1000)
