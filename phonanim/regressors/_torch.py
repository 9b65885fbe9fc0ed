"""Common parts of training with torch; imported by `fit` only, never to animate."""

from __future__ import annotations

import numpy as np

from phonanim.errors import MissingExtraError

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
