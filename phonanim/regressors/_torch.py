"""Common parts of training with torch; imported by `fit` only, never to animate."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.device import CHOSEN, PRECISION
from phonanim.errors import MissingExtraError, OptionError

try:
    import torch
except ImportError as error:
    raise MissingExtraError(
        "training needs PyTorch; install it with pip install 'phonanim[train]'"
    ) from error


def seeded_generator(rng: np.random.Generator) -> torch.Generator:
    """A torch generator seeded by the numpy one; also seeds torch's default, which initializes layers."""
    seed = int(rng.integers(2**31))
    torch.manual_seed(seed)
    return torch.Generator().manual_seed(seed)


def device() -> torch.device:
    """The device to train on. Raises OptionError when PyTorch does not find the one that was chosen."""
    name = CHOSEN.get()
    found = {"cuda": torch.cuda.is_available(), "mps": torch.backends.mps.is_available()}
    if name == "auto":
        name = next((one for one, there in found.items() if there), "cpu")
    if not found.get(name, True):
        raise OptionError(f"--device {name}: PyTorch finds no such device here; use auto or cpu")
    return torch.device(name)


def mixed_precision() -> AbstractContextManager[Any]:
    """A block in which products of matrices have 16 bits, if that was chosen."""
    if PRECISION.get() == "single":
        return nullcontext()
    return torch.autocast(device().type, torch.bfloat16)


def tensor(values: NDArray[Any]) -> torch.Tensor:
    """An array as a tensor on the device to train on; on the processor it shares the array's memory.

    Apple's devices have no double precision, so that such arrays become single there.
    """
    place = device()
    if place.type == "mps" and values.dtype == np.float64:
        values = values.astype(np.float32)
    return torch.from_numpy(values).to(place)


def array(values: torch.Tensor) -> NDArray[Any]:
    """A tensor of any device as an array, without its gradient."""
    return values.detach().cpu().numpy()
