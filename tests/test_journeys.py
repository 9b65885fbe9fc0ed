"""The pages whose commands are marked `sh`: every one runs and prints what the page shows."""

from __future__ import annotations

import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(path for path in (ROOT / "docs").rglob("*.md") if "\n```sh\n" in path.read_text("utf-8"))
NEEDS = {
    "game": ("ctranslate2", "pocketsphinx", "trimesh"),
    "studio": ("espeakng_loader",),
    "localization": ("espeakng_loader",),
    "avatar": ("websockets",),
    "student": ("torch", "sklearn", "matplotlib", "setuptools"),
}
MOST = {"retakes": 19}  # commands: four tools on one page
SMALLER = {"localization": {"2000": "24", " 500": " 6", "INT 5": "INT 1"}}


@pytest.fixture(scope="module")
def pages() -> dict[str, Any]:
    """The functions of scripts/run_pages.py."""
    return runpy.run_path(str(ROOT / "scripts/run_pages.py"))


def test_there_is_a_page_for_each_reader() -> None:
    assert {path.stem for path in PAGES} >= {"avatar", "game", "localization", "student", "studio", "timings"}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_page(path: Path, pages: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in NEEDS.get(path.stem, ()):
        pytest.importorskip(name)
    found = [str(ROOT)]
    if path.stem == "student":
        found.append(str(install_plugin(tmp_path / "site")))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(found))
    monkeypatch.setenv("PATH", os.pathsep.join([put_command(tmp_path / "bin"), os.environ["PATH"]]))
    text = path.read_text("utf-8")
    for large, small in SMALLER.get(path.stem, {}).items():
        assert large in text
        text = text.replace(large, small)
    assert 1 <= pages["run_page"](text, tmp_path, installs=False) <= MOST.get(path.stem, 12)


def install_plugin(site: Path) -> Path:
    """The example plugin in a folder of its own; the page installs it by its name alone."""
    pip = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "--target",
        str(site),
    ]
    source = site.with_name("plugin")
    subprocess.run(["cp", "-r", str(ROOT / "examples/plugin"), str(source)], check=True)
    subprocess.run([*pip, str(source)], check=True)
    return site


def put_command(folder: Path) -> str:
    """A folder whose `phonanim` and `python` are those that run the tests."""
    folder.mkdir()
    for name, arguments in (("phonanim", "-m phonanim "), ("python", "")):
        (folder / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments}"$@"\n')
        (folder / name).chmod(0o755)
    return str(folder)


def test_blocks_of_a_page(pages: dict[str, Any]) -> None:
    page = "a\n```sh\nls \\\n  -l\n# why\npwd\n```\n\n```text\nx ... y\n```\n"
    page += '```toml title="a.toml"\nb = 1\n```\n```\nno\n```\n'
    listed, file = pages["read_blocks"](page)
    assert listed.commands == ["ls -l", "pwd"]
    assert listed.printed == "x ... y\n"
    assert (file.name, file.text, file.commands) == ("a.toml", "b = 1\n", [])


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("a ... c", "a b\nb c", True),
        ("a b", "a  b\n", True),
        ("...\nb", "b", True),
        ("a ... c", "a b", False),
        ("a b", "a b c", False),
        ("r 1.0", "r 1x0", False),
    ],
)
def test_what_is_printed_is_compared(pages: dict[str, Any], shown: str, printed: str, same: bool) -> None:
    assert pages["prints"](shown, printed) is same


@pytest.mark.parametrize("command", ["false", "echo other"])
def test_a_page_that_is_wrong_is_an_error(pages: dict[str, Any], command: str, tmp_path: Path) -> None:
    with pytest.raises(pages["PageError"], match=command):
        pages["run_page"](f"```sh\n{command}\n```\n\n```text\nthis\n```\n", tmp_path)
