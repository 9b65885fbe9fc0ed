"""The device that PyTorch trains on; chosen by name here, so that nothing else needs PyTorch."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

DEVICES = ("auto", "cpu", "cuda", "mps")
CHOSEN: ContextVar[str] = ContextVar("device", default="cpu")


@contextmanager
def use_device(name: str) -> Iterator[None]:
    """Train on a device, one of DEVICES, within a block; "auto" is a graphics processor if there is one."""
    token = CHOSEN.set(name)
    try:
        yield
    finally:
        CHOSEN.reset(token)
