"""What every test may ask for."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from phonanim.core.threads import use_one_thread

os.environ.setdefault("PHONANIM_CACHE", "")  # features of sound are kept nowhere
use_one_thread()  # before NumPy is imported, as the commands do it

ROOT = Path(__file__).resolve().parent.parent
LONG = ("test_journeys.py", "test_hostile_files.py", "test_html.py", "test_comparison.py", "test_seeds.py")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files come first, so that no process is left with one of them at the end."""
    items.sort(key=lambda item: LONG.index(item.path.name) if item.path.name in LONG else len(LONG))


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


@pytest.fixture(scope="session")
def s3() -> Iterator[Any]:
    """The file system of an S3 server on this machine; skips without moto and s3fs."""
    servers = pytest.importorskip("moto.server", reason="needs moto[server] and s3fs")
    pytest.importorskip("s3fs", reason="needs moto[server] and s3fs")
    import fsspec

    server = servers.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{server.get_host_and_port()[1]}")
        for name, value in {"ACCESS_KEY_ID": "x", "SECRET_ACCESS_KEY": "x"}.items():
            patch.setenv(f"AWS_{name}", value)
        yield fsspec.filesystem("s3", use_listings_cache=False)
    server.stop()


@pytest.fixture
def bucket(s3: Any) -> Iterator[Any]:
    """The same with an empty bucket `show`."""
    s3.mkdir("show")
    yield s3
    s3.rm("show", recursive=True)


@pytest.fixture
def line(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The example line with its recording, as a.TextGrid and a.wav in the current folder."""
    for suffix in (".TextGrid", ".wav"):
        shutil.copy(root / "examples" / f"line{suffix}", tmp_path / f"a{suffix}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def line_without_sound(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example alignment in a folder without its recording."""
    return Path(shutil.copy(root / "examples" / "line.TextGrid", tmp_path_factory.mktemp("silent")))


@pytest.fixture
def made(tmp_path: Path) -> Callable[[str], tuple[Path, list[Any]]]:
    """Writes the sample of one data set; returns its folder and its recordings."""
    import dataset_samples

    from phonanim.datasets import load_dataset

    def make(name: str) -> tuple[Path, list[Any]]:
        if name == "hprc":
            pytest.importorskip("scipy", reason="needs the extra train")
        folder = tmp_path / name
        folder.mkdir()
        getattr(dataset_samples, name)(folder)
        return folder, list(load_dataset(name).recordings(folder))

    return make
