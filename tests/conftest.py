"""What every test may ask for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from phonanim.threads import one_thread

os.environ.setdefault("PHONANIM_CACHE", "")  # features of sound are kept nowhere
one_thread()  # before NumPy is imported, as the commands do it

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The recordings and alignments that are not part of the repository; skips where they are absent."""
    folder = Path(os.environ.get("PHONANIM_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no data in {folder}: set PHONANIM_DATA to the folder that holds grid_s1")
    return folder
