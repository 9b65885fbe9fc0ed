"""Recurrent layers in NumPy: long short-term memory, gated recurrent units, plain recurrence."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from phonanim.core.neural import sigmoid

Floats = NDArray[np.float32]


def run_lstm(signal: Floats, forward: Floats, recurrent: Floats, bias: Floats) -> Floats:
    """One LSTM layer, (sequences, frames, before) -> (sequences, frames, sides * size).

    Side 0 runs forwards. Side 1, if there is one, runs backwards (Hochreiter and
    Schmidhuber 1997, with the forget gate of Gers 2000).
    """
    sides = len(forward)
    given = np.stack([signal, signal[:, ::-1]][:sides])
    given = given @ forward[:, None] + bias[:, None, None]
    count, frames, size = given.shape[1], given.shape[2], recurrent.shape[1]
    output = np.empty((sides, count, frames, size), np.float32)
    state, cell = np.zeros((2, sides, count, size), np.float32)
    for frame in range(frames):
        gates = given[:, :, frame] + state @ recurrent
        enter, forget, new, leave = np.split(gates, 4, axis=2)
        cell = sigmoid(forget) * cell + sigmoid(enter) * np.tanh(new)
        state = sigmoid(leave) * np.tanh(cell)
        output[:, :, frame] = state
    if sides == 2:
        output[1] = output[1, :, ::-1].copy()
    return np.concatenate(list(output), axis=2)


def run_gru(signal: Floats, forward: Floats, recurrent: Floats, bias: Floats, recur_bias: Floats) -> Floats:
    """One layer of gated recurrent units, (sequences, steps, before) -> (sequences, steps, sides * size).

    Side 0 runs forwards. Side 1, if there is one, runs backwards (Cho et al. 2014, in the
    form of Medina's reference 30 and of torch: gates reset, update, new).
    """
    sides = len(forward)
    given = np.stack([signal, signal[:, ::-1]][:sides]) @ forward[:, None] + bias[:, None, None]
    count, steps, size = given.shape[1], given.shape[2], recurrent.shape[1]
    output = np.empty((sides, count, steps, size), np.float32)
    state = np.zeros((sides, count, size), np.float32)
    for step in range(steps):
        gates = state @ recurrent + recur_bias[:, None]
        both = sigmoid(given[:, :, step, : 2 * size] + gates[:, :, : 2 * size])
        reset, update = both[:, :, :size], both[:, :, size:]
        new = np.tanh(given[:, :, step, 2 * size :] + reset * gates[:, :, 2 * size :])
        state = new + update * (state - new)
        output[:, :, step] = state
    if sides == 2:
        output[1] = output[1, :, ::-1].copy()
    return np.concatenate(list(output), axis=2)


def run_rnn(signal: Floats, forward: Floats, recurrent: Floats, bias: Floats) -> Floats:
    """One layer of plain recurrence, (sequences, steps, before) -> (sequences, steps, sides * size).

    h = tanh(x W + h U + b) (Elman 1990). Side 0 runs forwards. Side 1, if there is one, runs backwards.
    """
    sides = len(forward)
    given = np.stack([signal, signal[:, ::-1]][:sides]) @ forward[:, None] + bias[:, None, None]
    output = np.empty_like(given, np.float32)
    state = np.zeros(given.shape[:2] + recurrent.shape[1:2], np.float32)
    for step in range(given.shape[2]):
        state = np.tanh(given[:, :, step] + state @ recurrent)
        output[:, :, step] = state
    if sides == 2:
        output[1] = output[1, :, ::-1].copy()
    return np.concatenate(list(output), axis=2)


def run_recurrent(decoder: str, signal: Floats, weights: Mapping[str, Floats], layer: int) -> Floats:
    """A layer "gru", "lstm" or "rnn" with the weights that `recurrent_names` lists."""
    layers: dict[str, Callable[..., Floats]] = {"gru": run_gru, "lstm": run_lstm, "rnn": run_rnn}
    return layers[decoder](signal, *(weights[f"{name}{layer}"] for name in recurrent_names(decoder)))


def recurrent_names(decoder: str) -> tuple[str, ...]:
    """The weights of each recurrent layer."""
    return ("forward", "recur", "bias", "recur_bias") if decoder == "gru" else ("forward", "recur", "bias")
