"""Random numbers as a function of a seed, a name and an index, so that any span of time can be computed."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

BLOCK = 32.0  # seconds after which a sequence of events restarts
GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FACTORS = tuple(map(np.uint64, (0xBF58476D1CE4E5B9, 0x94D049BB133111EB)))
SHIFTS = tuple(map(np.uint64, (30, 27, 31, 11)))


def seed_of(line: str) -> int:
    """The seed of a line, from its name."""
    return int.from_bytes(sha256(line.encode()).digest()[:6], "big")


def uniform(seed: int, name: str, index: Index) -> Array:
    """A fixed random number between 0 and 1 for each index (SplitMix64, Steele et al. 2014)."""
    return uniforms(seed, (name,), index)[0]


def uniforms(seed: int, names: tuple[str, ...], index: Index) -> Array:
    """The same for several names at once, (names, ...)."""
    x = np.asarray(index, np.int64).view(np.uint64) * GOLDEN  # overflow wraps around, as intended
    x = x + _keys(seed, names).reshape(-1, *[1] * x.ndim)
    for shift, factor in zip(SHIFTS, FACTORS, strict=False):
        x ^= x >> shift
        x *= factor
    x ^= x >> SHIFTS[2]
    x >>= SHIFTS[3]
    return (x + 0.5) / 2**53


@lru_cache(maxsize=256)
def _keys(seed: int, names: tuple[str, ...]) -> NDArray[np.uint64]:
    digests = [sha256(f"{seed} {name}".encode()).digest()[:8] for name in names]
    return np.array([int.from_bytes(digest, "big") for digest in digests], np.uint64)


def normal(seed: int, name: str, index: Index) -> Array:
    """A standard normal random number for each index (Box and Muller 1958)."""
    return normals(seed, (name,), index)[0]


def normals(seed: int, names: tuple[str, ...], index: Index) -> Array:
    """The same for several names at once, (names, ...)."""
    drawn = uniforms(seed, (*names, *(f"{name} turn" for name in names)), index)
    return as_normal(drawn[: len(names)], drawn[len(names) :])


def as_normal(first: Array, second: Array) -> Array:
    """Standard normal random numbers, from two that are uniform between 0 and 1."""
    return np.asarray(np.sqrt(-2 * np.log(first)) * np.cos(2 * np.pi * second))


def lognormal(seed: int, name: str, index: Index, mean: float, spread: float) -> Array:
    """Log-normal random numbers, by their mean and the standard deviation of the logarithm."""
    return as_lognormal(normal(seed, name, index), mean, spread)


def as_lognormal(drawn: Array, mean: float, spread: float) -> Array:
    """Log-normal random numbers, from standard normal ones."""
    return np.asarray(np.exp(np.log(mean) - spread**2 / 2 + spread * drawn))


def events(
    seed: int, name: str, gap: Callable[[Index], Array], least: float, start: float, end: float
) -> tuple[Array, Index]:
    """Events between two instants, separated by random gaps: (events,) seconds, and their numbers.

    `gap` gives seconds for each number, none below `least`. The sequence restarts every 32 seconds.
    """
    blocks = np.arange(int(start // BLOCK), int(end // BLOCK) + 1)
    most = int(BLOCK / least) + 1
    numbers = blocks[:, None] * most + np.arange(most)
    gaps = gap(numbers)
    gaps[:, 0] = least / 2 + (gaps[:, 0] - least / 2) * uniform(seed, f"{name} first", blocks)
    places = np.cumsum(gaps, axis=1)
    times = places + blocks[:, None] * BLOCK
    kept = (places < BLOCK - least / 2) & (times >= start) & (times < end)
    return times[kept], numbers[kept]


def wander(seed: int, name: str, times: Array, period: float) -> Array:
    """A random curve that turns about every `period` seconds, (frames,), with standard deviation near 1."""
    place = times / period
    cell = np.floor(place).astype(np.int64)
    share = place - cell
    share = share**3 * (share * (6 * share - 15) + 10)
    first = int(cell.min(initial=0))
    values = normal(seed, name, np.arange(first, int(cell.max(initial=0)) + 2))
    before, after = values.take(cell - first), values.take(cell - first + 1)
    return np.asarray(1.2 * (before + (after - before) * share))


def number_of(times: Array) -> Index:
    """A number for each event: its instant in milliseconds."""
    return np.rint(np.asarray(times) * 1000).astype(np.int64)
