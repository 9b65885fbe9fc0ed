"""Small made-up speech for tests: tracks from phones and seconds, a face that opens and spreads."""

from __future__ import annotations

import numpy as np

from phonanim.face import FaceModel, fit_face
from phonanim.inventory import INVENTORY
from phonanim.phones import PhoneTrack
from phonanim.regressors import Examples

NUMBERS = (2, 13, 14, 61, 291, 0, 17, 80, 88, 81, 178, 82, 87, 312, 317, 311, 402, 310, 318, 6, 168)


def track_of(text: str) -> PhoneTrack:
    """'sil 0.3 m 0.1 aa 0.2' as a track."""
    words = text.split()
    lengths = [float(word) for word in words[1::2]]
    bounds = np.concatenate([[0.0], np.cumsum(lengths)])
    return PhoneTrack(INVENTORY.codes(words[::2]), bounds, tuple(words[::2]))


def random_track(rng: np.random.Generator, segments: int = 20) -> PhoneTrack:
    """Phones and durations drawn at random, silence at both ends."""
    codes = rng.integers(0, 41, segments).astype(np.uint8)
    codes[[0, -1]] = 0
    bounds = np.concatenate([[0.0], np.cumsum(rng.uniform(0.03, 0.2, segments))])
    return PhoneTrack(codes, bounds, tuple(INVENTORY.phones[c] for c in codes))


def made_up_face(rng: np.random.Generator) -> FaceModel:
    """A face of 21 landmarks whose modes open the lips, spread the corners and push the lips forward."""
    rows = {number: row for row, number in enumerate(NUMBERS)}
    mean = np.zeros((len(NUMBERS), 3))
    mean[:, 1] = -60
    mean[[rows[6], rows[168], rows[2]], 1] = (0, 5, -40)
    uppers = [rows[n] for n in (13, 0, 80, 81, 82, 312, 311, 310)]
    lowers = [rows[n] for n in (14, 17, 88, 178, 87, 317, 402, 318)]
    mean[uppers, 1], mean[lowers, 1] = -57, -60
    mean[[rows[61], rows[291]], 0] = (-25, 25)
    shapes = np.tile(mean, (400, 1, 1))
    opening, spread, forward = rng.normal(0, [[3.0], [1.5], [0.7]], (3, 400))
    shapes[:, lowers, 1] -= opening[:, None]
    shapes[:, uppers, 1] += 0.2 * opening[:, None]
    shapes[:, rows[61], 0] -= spread
    shapes[:, rows[291], 0] += spread
    shapes[:, uppers + lowers, 2] += forward[:, None]
    return fit_face(shapes, np.array(NUMBERS), variance=0.999)


def made_up_examples(rng: np.random.Generator, clips: int = 12, modes: int = 3) -> Examples:
    """Clips whose modes are a smoothed function of the phones, so that a regressor can learn them."""
    levels = rng.normal(0, 5, (41, modes))
    tracks = tuple(random_track(rng) for _ in range(clips))
    times = tuple((np.arange(int(track.duration * 25)) + 0.5) / 25 for track in tracks)
    targets = tuple(levels[t.sample(at)].astype(np.float32) for t, at in zip(tracks, times, strict=True))
    return Examples(tracks, times, targets, (1.0,) * clips)
