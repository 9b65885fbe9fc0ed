"""Train the network that recognizes phones, and write phonanim/models/audio/recognizer.safetensors.

    python scripts/recognizer_data.py LJSPEECH UDHR GRID -o work/recognizer.npz
    python scripts/train_recognizer.py work/recognizer.npz -o work/1.safetensors --steps 700 --rate 3e-3
    python scripts/train_recognizer.py work/recognizer.npz -o work/2.safetensors --resume work/1.pt \\
        --rate 1e-3 --seed 2
    python scripts/train_recognizer.py work/recognizer.npz -o work/3.safetensors --resume work/2.pt --seed 3

Runs after the first draw the voices of people twice as often. Speech is changed before it is used: rate,
pitch, length of the vocal tract, noise, echo, telephone, tone of the microphone, level. One clip of twenty is
kept to see how many steps of 10 ms are named rightly.
"""

from __future__ import annotations

import time
from pathlib import Path

import click
import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import save_file
from torch import nn

from phonanim.media.mel import mel_filters
from phonanim.recognition.spectrum import BANDS, HOP, RATE, WINDOW, VoiceMean, log_bands
from phonanim.speech.inventory import N_PHONES

Floats = NDArray[np.float32]
OFFSETS = ((-2, -1, 0, 1, 2), (-1, 0, 1), (-2, 0, 2), (-3, 0, 3), (-8, -4, 0), (-16, -8, 0), (0,))
WIDTH = 128
BATCH = 12  # clips
LONGEST = 700  # steps of a clip
WARPS = np.linspace(0.82, 1.22, 21)
SMOOTHING = 0.05
BINS = WINDOW // 2 + 1
SHORT_PAUSE = 30  # code of sp
FIRST_PERSON = 20  # row of recognizer_voices.tsv; voices from here on are of people


class Net(nn.Module):
    """Convolutions at OFFSETS, normalized, the input added where the width allows."""

    def __init__(self) -> None:
        super().__init__()
        widths = [BANDS, *[WIDTH] * (len(OFFSETS) - 1), N_PHONES]
        self.convolutions = nn.ModuleList(
            nn.Conv1d(a, b, len(o), dilation=o[1] - o[0] if len(o) > 1 else 1)
            for o, a, b in zip(OFFSETS, widths, widths[1:], strict=False)
        )
        self.norms = nn.ModuleList(nn.BatchNorm1d(WIDTH) for _ in OFFSETS[1:])

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(clips, BANDS, steps) -> scores (clips, N_PHONES, steps)."""
        for number, (offsets, convolution) in enumerate(zip(OFFSETS, self.convolutions, strict=True)):
            y = convolution(nn.functional.pad(x, (-min(offsets), max(offsets))))
            if number == len(OFFSETS) - 1:
                return y
            y = self.norms[number](y)
            x = torch.relu(y + x if number else y)
        raise AssertionError

    def tensors(self) -> dict[str, NDArray[np.generic]]:
        """The layers with their normalization in them, as phonanim.recognition.network reads them."""
        found: dict[str, NDArray[np.generic]] = {}
        for number, (offsets, convolution) in enumerate(zip(OFFSETS, self.convolutions, strict=True)):
            weights, bias = convolution.weight.detach(), convolution.bias.detach()
            if number < len(self.norms):
                norm = self.norms[number]
                scale = norm.weight.detach() / torch.sqrt(norm.running_var + norm.eps)
                weights = weights * scale[:, None, None]
                bias = (bias - norm.running_mean) * scale + norm.bias.detach()
            flat = weights.permute(2, 1, 0).reshape(-1, weights.shape[0])
            found[f"weights{number}"] = np.ascontiguousarray(flat.numpy().astype(np.float16))
            found[f"bias{number}"] = bias.numpy().astype(np.float32)
            found[f"offsets{number}"] = np.array(offsets, np.int64)
        return found


class Clips:
    """The clips of scripts/recognizer_data.py."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as stored:
            self.samples, self.codes = stored["samples"], stored["codes"].astype(np.int64)
            self.frames, self.voices = stored["frames"], stored["voices"]
        self.starts = np.concatenate([[0], np.cumsum(self.frames)[:-1]])
        self.filters = [warped_filters(warp) for warp in WARPS]

    def __len__(self) -> int:
        return len(self.frames)

    def clip(self, number: int) -> tuple[Floats, NDArray[np.int64]]:
        """Samples in -1..1 and codes."""
        start, count = self.starts[number], self.frames[number]
        samples = self.samples[start * HOP : (start + count) * HOP].astype(np.float32) / 32768
        return samples, self.codes[start : start + count]


def warped_filters(warp: float) -> Floats:
    """Mel filters of frequencies times `warp`, as from a vocal tract of another length."""
    filters = mel_filters(RATE, WINDOW, BANDS)
    place = np.minimum(np.arange(BINS) * warp, BINS - 1)
    below = np.minimum(place.astype(int), BINS - 2)
    share = (place - below)[:, None]
    return ((1 - share) * filters[below] + share * filters[below + 1]).astype(np.float32)


def power_of(samples: Floats) -> Floats:
    """Power spectra centred at steps, (steps, BINS)."""
    padded = np.pad(samples, WINDOW // 2)
    frames = np.lib.stride_tricks.sliding_window_view(padded, WINDOW)[: len(samples) // HOP * HOP : HOP]
    return (np.abs(np.fft.rfft(frames * np.hanning(WINDOW + 1)[:-1].astype(np.float32))) ** 2).astype(
        np.float32
    )


def changed(
    samples: Floats, codes: NDArray[np.int64], clips: Clips, rng: np.random.Generator
) -> tuple[Floats, NDArray[np.int64]]:
    """Log bands (steps, BANDS) and codes of a clip as another voice in another room would give it."""
    begin = rng.integers(0, 30) if len(codes) > 200 else 0
    samples, codes = samples[begin * HOP :], codes[begin:]
    speed = rng.uniform(0.85, 1.18) if rng.random() < 0.6 else 1.0
    count = int(len(codes) / speed)
    samples = np.interp(np.arange(count * HOP) * speed, np.arange(len(samples)), samples).astype(np.float32)
    codes = codes[np.minimum((np.arange(count) * speed).round().astype(int), len(codes) - 1)]
    power = power_of(samples[: LONGEST * HOP])
    codes = codes[: len(power)]
    loud = np.quantile(power.sum(axis=1), 0.8) + 1e-9
    if rng.random() < 0.3:
        power = echoed(power, rng)
    power = power * tone(rng, 0.8)
    if rng.random() < 0.7:
        noise = rng.exponential(1.0, power.shape).astype(np.float32) * tone(rng, 1.5)
        noise *= loud / noise.sum(axis=1).mean() * 10 ** (-rng.uniform(3, 45) / 10)
        power = power + noise
    if rng.random() < 0.15:
        band = np.ones(BINS, np.float32)
        band[: int(rng.uniform(100, 320) / 40)], band[int(rng.uniform(3300, 4200) / 40) :] = 1e-3, 1e-4
        power = power * band
    gain = 10 ** (rng.uniform(-70, -5) / 10) * RATE / loud if rng.random() < 0.5 else 1.0
    bands = log_bands((power * np.float32(gain)), clips.filters[rng.integers(len(WARPS))])
    return bands, codes


def tone(rng: np.random.Generator, most: float) -> Floats:
    """A smooth random curve of power over frequency, (BINS,); deviation of its knots `most` nats."""
    knots = np.cumsum(rng.normal(0, most / 2, 7)) + rng.normal(0, most / 2) * np.linspace(-1, 1, 7)
    return np.exp(np.interp(np.arange(BINS), np.linspace(0, BINS, 7), knots - knots.mean())).astype(
        np.float32
    )


def echoed(power: Floats, rng: np.random.Generator) -> Floats:
    """Power with the tail of a room."""
    kept = 10 ** (-6 * HOP / RATE / rng.uniform(0.15, 0.7))
    tail, gain, found = np.zeros(BINS, np.float32), rng.uniform(0.02, 0.3), power.copy()
    for step in range(len(power)):
        found[step] += gain * tail
        tail = kept * (tail + power[step])
    return found


def batch_of(
    numbers: NDArray[np.int64], clips: Clips, rng: np.random.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Inputs (clips, BANDS, steps) and codes (clips, steps); -1 where a clip has ended."""
    found = [changed(*clips.clip(number), clips, rng) for number in numbers]
    longest = max(len(codes) for _, codes in found)
    bands = np.full((len(found), longest, BANDS), -18.0, np.float32)
    codes = np.full((len(found), longest), -1)
    for row, (own, said) in enumerate(found):
        bands[row, : len(own)], codes[row, : len(said)] = own, said
    mean = VoiceMean((len(found),))
    if rng.random() < 0.5:  # a voice that was used before
        mean.subtract(bands)
    return torch.from_numpy(mean.subtract(bands)).transpose(1, 2), torch.from_numpy(codes)


def followers(clips: Clips, chosen: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Log shares of phones, and log probabilities that one follows another."""
    shares, pairs = np.ones(N_PHONES), np.full((N_PHONES, N_PHONES), 0.5)
    for number in chosen:
        codes = clips.clip(number)[1]
        shares += np.bincount(codes, minlength=N_PHONES)
        change = np.flatnonzero(np.diff(codes))
        np.add.at(pairs, (codes[change], codes[change + 1]), 1)
    pairs[:, SHORT_PAUSE] = 1e-9  # it is silence
    return np.log(shares / shares.sum()).astype(np.float32), np.log(
        pairs / pairs.sum(axis=1, keepdims=True)
    ).astype(np.float32)


@click.command()
@click.argument("data", type=click.Path(exists=True, path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
@click.option("--steps", type=int, default=400, help="Batches.")
@click.option("--rate", type=float, default=1.5e-3, help="Highest learning rate.")
@click.option("--seed", type=int, default=1, help="Seed of the order and of the changes.")
@click.option("--resume", type=click.Path(exists=True, path_type=Path), help="State of an earlier run.")
def main(data: Path, output: Path, steps: int, rate: float, seed: int, resume: Path | None) -> None:
    torch.manual_seed(1)
    torch.set_num_threads(1)
    rng, clips = np.random.default_rng(seed), Clips(data)
    kept = np.arange(len(clips)) % 20 == 7
    train, held = np.flatnonzero(~kept), np.flatnonzero(kept)
    people = train[clips.voices[train] >= FIRST_PERSON] if resume else train[:0]
    turns = np.concatenate([train, people])
    net = Net()
    if resume:
        net.load_state_dict(torch.load(resume))
    optimizer = torch.optim.AdamW(net.parameters(), rate, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps, pct_start=0.15)
    loss_of = nn.CrossEntropyLoss(ignore_index=-1, label_smoothing=SMOOTHING)
    began, total, right, seen = time.process_time(), 0.0, 0, 0
    order = np.empty(0, np.int64)
    for step in range(1, steps + 1):
        if len(order) < BATCH:
            order = rng.permutation(turns)
        numbers, order = order[:BATCH], order[BATCH:]
        inputs, codes = batch_of(numbers, clips, rng)
        scores = net(inputs)
        loss = loss_of(scores, codes)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        total += float(loss.detach())
        spoken = codes > 0
        right += int((scores.argmax(1) == codes)[spoken].sum())
        seen += int(spoken.sum())
        if step % 100 == 0:
            spent = time.process_time() - began
            click.echo(f"{step}: loss {total / 100:.3f}, {right / seen:.1%} of speech right, {spent:.0f} s")
            total, right, seen = 0.0, 0, 0
    net.eval()
    torch.save(net.state_dict(), output.with_suffix(".pt"))
    prior, follows = followers(clips, train)
    save_file({**net.tensors(), "prior": prior, "follows": follows}, output)
    report(net, clips, held)


def report(net: Net, clips: Clips, held: NDArray[np.int64]) -> None:
    """Steps of speech that are named rightly in clips that were not learned from, by voice, unchanged."""
    for voice in np.unique(clips.voices):
        right, seen = 0, 0
        for number in held[clips.voices[held] == voice][:20]:
            samples, codes = clips.clip(number)
            bands = log_bands(power_of(samples), mel_filters(RATE, WINDOW, BANDS))
            with torch.no_grad():
                found = net(torch.from_numpy(VoiceMean().subtract(bands).T[None]))[0].argmax(0).numpy()
            right, seen = right + int((found == codes)[codes > 0].sum()), seen + int((codes > 0).sum())
        click.echo(f"voice {voice}: {right / max(seen, 1):.1%}")


if __name__ == "__main__":
    main()
