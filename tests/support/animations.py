"""Animations for tests: smooth curves of every ARKit control, with phones and words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from phonanim.animation.animation import Animation
from phonanim.rig import load_rig
from phonanim.rig.neck import TURNS
from phonanim.speech.alignment import Interval

PHONES = (
    ("sil", 0.0, 0.1),
    ("HH", 0.1, 0.2),
    ("ə", 0.2, 0.3),
    ("L", 0.3, 0.4),
    ("OW", 0.4, 0.7),
    ("", 0.7, 1.0),
)


def line(frames: int = 61, fps: float = 60.0, seed: int = 0) -> Animation:
    """One second of "hello", every control between 0 and 1."""
    rng = np.random.default_rng(seed)
    names = load_rig("arkit").controls
    times = np.arange(frames)[:, None] / fps
    waves = np.sin(2 * np.pi * (rng.uniform(0.5, 4, len(names)) * times + rng.uniform(0, 1, len(names))))
    phones = tuple(Interval(*phone) for phone in PHONES)
    return Animation(
        values=((waves + 1) / 2).astype(np.float32),
        channels=names,
        fps=fps,
        rig="arkit",
        phones=phones,
        words=(Interval("hello", 0.1, 0.7),),
        provenance={"tool": "phonanim test", "input": "hello.TextGrid"},
    )


def only(animation: Animation, **weights: float) -> Animation:
    """The same line with these controls held and every other at zero."""
    values = np.zeros_like(animation.values)
    for name, weight in weights.items():
        values[:, animation.channels.index(name)] = weight
    return replace(animation, values=values)


def metahuman(**options: float) -> Animation:
    """The same line under MetaHuman's names."""
    animation = line(**options)
    names = tuple(f"CTRL_expressions_{name}" for name in animation.channels)
    return replace(animation, channels=names, rig="metahuman")


def vowels(**options: float) -> Animation:
    """The same line on VRM's five vowels, with the turns of the head."""
    animation = line(**options)
    columns = [*range(5), *(animation.channels.index(name) for name in TURNS)]
    names = ("aa", "ih", "ou", "ee", "oh", *TURNS)
    return replace(animation, channels=names, values=animation.values[:, columns], rig="vrm")


def speaking(
    fps: float = 30.0,
    late: float = 0.0,
    channels: tuple[str, ...] = ("jawOpen", "mouthPucker"),
    seconds: float = 2.0,
) -> Animation:
    """Two ARKit controls that open and purse, `late` seconds behind."""
    times = np.arange(round(seconds * fps)) / fps - late
    curves = [0.3 + 0.3 * np.sin(9 * times), 0.2 + 0.2 * np.sin(5 * times)]
    return Animation(np.array(curves, np.float32).T, channels, fps, "arkit")
