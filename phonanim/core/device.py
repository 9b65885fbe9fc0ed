"""The device and the precision that PyTorch trains with, by name, so that nothing else needs PyTorch."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

DEVICES = ("auto", "cpu", "cuda", "mps")
PRECISIONS = ("single", "bf16")
CHOSEN: ContextVar[str] = ContextVar("device", default="cpu")
PRECISION: ContextVar[str] = ContextVar("precision", default="single")


@contextmanager
def use_device(name: str, precision: str = "single") -> Iterator[None]:
    """Train on a device, one of DEVICES, within a block; "auto" is a graphics processor if there is one.

    With the precision "bf16" products of matrices have 16 bits, and weights, sums and losses stay single.
    """
    device, numbers = CHOSEN.set(name), PRECISION.set(precision)
    try:
        yield
    finally:
        CHOSEN.reset(device)
        PRECISION.reset(numbers)
