"""Gradient descent for the audio-driven regressors; imported by their `fit` only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from phonanim.regressors import Examples, Progress
from phonanim.regressors._audio_config import Settings
from phonanim.regressors._audio_model import AudioModel
from phonanim.regressors._decoders import decode
from phonanim.regressors._steps import cached_encoder, step_times
from phonanim.regressors._torch import device, mixed_precision, seeded_generator, tensor
from phonanim.regressors._torch_decoders import Network, export_weights
from phonanim.regressors._torch_journal import State, state_key
from phonanim.regressors._training_steps import (
    BLOCK,
    Scaling,
    Steps,
    blocks_of,
    column_means,
    gather_steps,
    release,
)
from phonanim.speech.inventory import N_PHONES

Floats = NDArray[np.float32]
Model = TypeVar("Model", bound=AudioModel)
LONGEST_STEP = 1.0  # largest norm of a gradient, because gradients of recurrent layers explode


def fit_audio(
    build: type[Model],
    config: Settings,
    train: Examples,
    validation: Examples,
    rng: np.random.Generator,
    progress: Progress,
    journal: Path | None,
) -> Model:
    """Train on random windows of the clips; the weights with the least validation error are kept.

    The error is the mean square of modes (that is, of landmarks, mm²) over whole clips, decoded as in use.
    Every epoch has a separate seed, so that an interrupted and continued training has the same result as an
    uninterrupted one.
    """
    seed = int(rng.integers(2**31))
    seeded_generator(np.random.default_rng(seed))
    steps = gather_steps(build, config, train)
    held_out = gather_steps(build, config, validation) if len(validation) else None
    scaling = Scaling.of(config, steps)
    layers, dims = steps.values.shape[1:]
    labels = N_PHONES
    if config.labels == "allophones":
        steps, labels = with_allophones(steps, config, train)
    network = Network(config, layers, dims, steps.targets.shape[1], labels).to(device())
    network.start_from((column_means(steps.targets) - scaling.low) / scaling.span)
    optimizer = OPTIMIZERS[config.optimizer](network.parameters(), lr=config.learning_rate)
    state = State(network, optimizer, [], [], training_key(config, seed, steps), journal)
    state.resume()
    identity = cached_encoder(config.encoder).identity

    def model() -> Model:
        mix, weights = export_weights(network, scaling.low, scaling.span)
        return build(config, scaling.centre, scaling.scale, mix, weights, identity)

    while not state.ended(config):
        epoch = len(state.curve)
        if config.cosine:
            rate = config.learning_rate * (1 + np.cos(np.pi * epoch / config.epochs)) / 2
            optimizer.param_groups[0]["lr"] = float(rate)
        network.train()
        losses = [
            step(
                network,
                optimizer,
                loss(config, network, scaling, *batch, robust=starts_robust(config, state)),
            )
            for batch in batches(config, steps, np.random.default_rng([seed, epoch]))
        ]
        network.eval()
        state.add(float(np.mean(losses)), validation_error(model(), held_out))
        progress((epoch + 1) / config.epochs)
    state.restore()
    progress(1.0)
    return model()


def with_allophones(steps: Steps, config: Settings, examples: Examples) -> tuple[Steps, int]:
    """The steps with the labels of the alignments instead of phones, and the number of labels."""
    names = sorted({label for track in examples.tracks for label in track.labels})
    place = {label: code for code, label in enumerate(names)}
    codes = [
        np.array([place[label] for label in track.labels])[
            track.segment_at(step_times(s.duration, config.rate))
        ]
        for track, s in zip(examples.tracks, examples.sounds, strict=True)
    ]
    return replace(steps, codes=np.concatenate(codes)), len(names)


def starts_robust(config: Settings, state: State) -> bool:
    """Whether the loss is still the L1 error: until the mean loss of an epoch is below `l1_until`."""
    return not any(mean < config.l1_until for mean, _ in state.curve) and config.l1_until > 0


OPTIMIZERS = {"adam": torch.optim.Adam, "radam": torch.optim.RAdam}
Batch = tuple[Tensor, Tensor, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Tensor]


def batches(config: Settings, steps: Steps, rng: np.random.Generator) -> Iterator[Batch]:
    """Windows at random positions, enough to cover each clip once, or one at every `stride` steps.

    Shorter clips repeat their last step.
    """
    torch.manual_seed(int(rng.integers(2**31)))  # for the dropout
    wide = min(config.window, int(steps.lengths.max()))
    spare = np.maximum(steps.lengths - wide, 0)
    stride = getattr(config, "stride", 0)
    counts = spare // stride + 1 if stride else np.maximum(1, np.round(steps.lengths / wide).astype(int))
    clips = np.repeat(np.arange(len(steps.lengths)), counts)
    places = np.concatenate([np.arange(count) * stride for count in counts])
    order = rng.permutation(len(clips))
    clips, places = clips[order], places[order]
    for begin in range(0, len(clips), config.batch):
        chosen = clips[begin : begin + config.batch]
        first = places[begin : begin + config.batch] if stride else rng.integers(0, spare[chosen] + 1)
        rows = np.minimum(first[:, None] + np.arange(wide), steps.lengths[chosen][:, None] - 1)
        rows += steps.starts[chosen][:, None]
        values = torch.from_numpy(steps.values[rows].astype(np.float32))
        targets, weights = torch.from_numpy(steps.targets[rows]), torch.from_numpy(steps.weights[chosen])
        release(steps.values)
        release(steps.targets)
        yield values, targets, steps.codes[rows], steps.segments[rows], steps.styles[chosen], weights


def loss(
    config: Settings,
    network: Network,
    scaling: Scaling,
    values: Tensor,
    targets: Tensor,
    codes: NDArray[np.int64],
    segments: NDArray[np.int64],
    styles: NDArray[np.int64],
    weights: Tensor,
    robust: bool = False,
) -> Tensor:
    """Errors of modes, their velocity and acceleration (eq. 4.8 to 4.13), and the auxiliary tasks.

    Errors are squared; `robust` takes their size, which is the L1 error.
    """
    values, targets, weights = (part.to(device()) for part in (values, targets, weights))
    normal = (values - tensor(scaling.centre)) * tensor(scaling.scale)
    with mixed_precision():
        hidden, found = (part.float() for part in network(normal, tensor(styles)))
    apart = found - (targets - tensor(scaling.low)) / tensor(scaling.span)
    total = torch.zeros((), device=found.device)
    for weight in (1.0, config.velocity, config.acceleration):
        if weight:
            errors = apart.abs() if robust else apart**2
            total = total + weight * (errors.mean(dim=(1, 2)) * weights).mean()
        apart = apart.diff(dim=1)
    if config.classifier:
        shares = network.classifier(hidden).transpose(1, 2)
        total = total + config.classifier * torch.nn.functional.cross_entropy(shares, tensor(codes))
    if config.ctc:
        total = total + config.ctc * sequence_loss(network.ctc(hidden), codes, segments)
    return total


def sequence_loss(scores: Tensor, codes: NDArray[np.int64], segments: NDArray[np.int64]) -> Tensor:
    """Connectionist temporal classification (Graves et al. 2006; eq. 4.28) of the phones in each window.

    The last of the scores, (windows, steps, labels + 1), is that of no label.
    """
    begins = np.diff(segments, axis=1, prepend=-1) != 0
    lengths = torch.full((len(codes),), codes.shape[1], dtype=torch.long)
    return torch.nn.functional.ctc_loss(
        scores.log_softmax(dim=2).transpose(0, 1),
        tensor(codes[begins]),
        lengths,
        tensor(begins.sum(axis=1)),
        blank=scores.shape[2] - 1,
        zero_infinity=True,
    )


def step(network: Network, optimizer: Any, total: Tensor) -> float:
    """One step of descent; returns the loss."""
    optimizer.zero_grad()
    torch.autograd.backward(total)
    torch.nn.utils.clip_grad_norm_(network.parameters(), LONGEST_STEP)
    optimizer.step()
    return float(total.detach())


def validation_error(model: AudioModel, steps: Steps | None) -> float:
    """Mean square error of whole clips in mm² per mode, 0 without clips."""
    if steps is None:
        return 0.0
    total = 0.0
    for length, style in np.unique(np.stack([steps.lengths, steps.styles], axis=1), axis=0):
        chosen = steps.starts[(steps.lengths == length) & (steps.styles == style)]
        config = replace(model.config, style=int(style))
        most = max(1, min(32, BLOCK // max(1, int(length) * steps.targets[:1].nbytes)))
        for some in np.array_split(chosen, -(-len(chosen) // most)):
            rows = some[:, None] + np.arange(length)
            mixed = np.stack([model.mix_layers(steps.values[row].astype(np.float32)) for row in rows])
            found = decode(config, model.weights, mixed)
            total += float(((found - steps.targets[rows]) ** 2).sum())
    return total / steps.targets.size


def training_key(config: Settings, seed: int, steps: Steps) -> str:
    """The key of a training on steps (`state_key`)."""
    some = steps.values[:: max(1, len(steps.values) // 1000)]
    return state_key(config, seed, chain(blocks_of(steps.targets), [some]))
