"""Whether PyTorch, which every training needs, is installed."""

from __future__ import annotations

from importlib.util import find_spec

from phonanim.errors import MissingExtraError


def require_torch() -> None:
    """Raise MissingExtraError where PyTorch is not installed."""
    if find_spec("torch") is None:
        raise MissingExtraError("training needs PyTorch; install it with pip install 'phonanim[train]'")
