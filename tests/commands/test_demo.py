from __future__ import annotations

import json
import webbrowser
from pathlib import Path

import pytest
from click.testing import CliRunner

from phonanim.commands.animate import command as animate_command
from phonanim.commands.demo import command
from phonanim.core.lexicon import LEXICON
from phonanim.errors import OptionError


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    pages: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: pages.append(url) or True)
    return pages


def test_the_demo_speaks_the_example_with_sound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opened: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(command, [], catch_exceptions=False)
    assert done.exit_code == 0
    assert opened == [(tmp_path / "demo.html").as_uri()]
    page = Path("demo.html").read_text("utf-8")
    assert "audio/wav" in page
    assert "father" in page
    assert sorted(path.name for path in tmp_path.iterdir()) == ["demo.html"]


def test_the_demo_speaks_a_sentence(tmp_path: Path, opened: list[str]) -> None:
    pytest.importorskip("espeakng_loader", reason="needs the extra espeak")
    target = str(tmp_path / "own.html")
    done = CliRunner().invoke(command, ["Mama Bob", "-o", target, "--no-view", "--json"])
    assert json.loads(done.stdout)["words"] == ["Mama", "Bob"]
    assert opened == []


def test_the_demo_is_a_page(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=r"the demo is a page; name it \.html"):
        CliRunner().invoke(command, ["-o", str(tmp_path / "a.glb")], catch_exceptions=False)


def test_the_shipped_line_is_the_example(root: Path) -> None:
    for suffix in (".TextGrid", ".wav"):
        name = f"line{suffix}"
        assert (LEXICON / "demo" / name).read_bytes() == (root / "examples" / name).read_bytes()


@pytest.mark.parametrize("output", ["a.csv", "a.html"])
def test_an_animation_is_shown(line: Path, opened: list[str], output: str) -> None:
    done = CliRunner().invoke(animate_command, ["a.TextGrid", "-o", output, "--view"], catch_exceptions=False)
    assert done.exit_code == 0
    assert opened[0].endswith("/a.html")
    assert "audio/wav" in Path(opened[0].removeprefix("file://")).read_text("utf-8")
