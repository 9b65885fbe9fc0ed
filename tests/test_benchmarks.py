"""The scripts of benchmarks/ still import, tell what they need, and run to their end on small inputs."""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent.parent / "benchmarks"
SCRIPTS = sorted(
    path.name for path in FOLDER.glob("*.py") if 'if __name__ == "__main__"' in path.read_text("utf-8")
)
LINE = str(FOLDER.parent / "examples" / "line.TextGrid")


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """Run a script as `python benchmarks/NAME WORD...` does, in this process."""
    known, environment = set(sys.modules), dict(os.environ)

    def run(name: str, *words: str) -> None:
        monkeypatch.setattr(sys, "argv", [str(FOLDER / name), *words])
        monkeypatch.setattr(sys, "path", [str(FOLDER), *sys.path])
        try:
            runpy.run_path(str(FOLDER / name), run_name="__main__")
        except SystemExit as end:
            if end.code:
                pytest.fail(f"{name} ends with {end.code}")

    yield run
    for name in set(sys.modules) - known:  # they have names that others may have too
        if Path(getattr(sys.modules[name], "__file__", None) or "").parent == FOLDER:
            del sys.modules[name]
    os.environ.clear()
    os.environ.update(environment)


@pytest.mark.parametrize("name", SCRIPTS)
def test_each_tells_its_use(
    name: str, script: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    script(name, "--help")
    assert "usage: " in capsys.readouterr().out.lower()
