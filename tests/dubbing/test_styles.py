"""Styles that a table names."""

from __future__ import annotations

from pathlib import Path

import pytest

from phonanim.__main__ import run
from phonanim.articulation.styles import DIALS, find_style, read_styles
from phonanim.dubbing.lines import read_lines
from phonanim.dubbing.row import Common
from phonanim.errors import OptionError
from phonanim.options import Options


def table(folder: Path, rows: str) -> str:
    (folder / "a.TextGrid").write_text("x")
    (folder / "t.csv").write_text("id,alignment,style,jaw\n" + rows)
    return str(folder / "t.csv")


def own(folder: Path, text: str) -> Path:
    (folder / "styles.toml").write_text(text)
    return folder / "styles.toml"


def test_the_shipped_styles() -> None:
    styles = read_styles()
    assert styles["normal"] == {}
    assert styles["shouted"]["jaw"] > 1 > styles["mumbled"]["jaw"]
    assert all(set(gains) <= set(DIALS) for gains in styles.values())


def test_options_then_style_then_cells(tmp_path: Path) -> None:
    styles = own(tmp_path, "[Loud]\nintensity = 2\njaw = 1.5\n")
    source = table(tmp_path, "x,a.TextGrid,LOUD,\ny,a.TextGrid,loud,0.5\nz,a.TextGrid,,\n")
    lines = read_lines(source, Common(Options(jaw=3.0, lips=0.9), read_styles(styles)))
    assert [line.options for line in lines.lines] == [
        Options(intensity=2.0, jaw=1.5, lips=0.9),
        Options(intensity=2.0, jaw=0.5, lips=0.9),
        Options(jaw=3.0, lips=0.9),
    ]


def test_an_unknown_style_costs_its_row(tmp_path: Path) -> None:
    lines = read_lines(table(tmp_path, "x,a.TextGrid,shuoted,\ny,a.TextGrid,quiet,\n"), Common())
    assert [line.id for line in lines.lines] == ["y"]
    assert lines.faults[0].message == "there is no style 'shuoted'; did you mean 'shouted'?"
    assert lines.faults[0].place == "t.csv row 2"


def test_a_style_like_no_other(tmp_path: Path) -> None:
    styles = read_styles(own(tmp_path, "[loud]\n[soft]\n"))
    with pytest.raises(OptionError, match=r"there is no style '\?'; choose loud, soft"):
        find_style("?", styles)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[loud", r"styles.toml: it is not TOML: .*; correct it"),
        ("loud = 2", r"styles.toml: 'loud' is not a style; write \[loud\] and its settings below"),
        ("[loud]\nchin = 2", r"style 'loud': 'chin' is not a setting; there are intensity, jaw, lips"),
        ("[loud]\njaw = 5", r"style 'loud': jaw = 5; give a number from 0 to 4"),
        ("[loud]\njaw = nan", r"style 'loud': jaw = nan; give a number from 0 to 4"),
        ("[loud]\njaw = true", r"style 'loud': jaw = True; give a number from 0 to 4"),
        ("[loud]\njaw = 'wide'", r"style 'loud': jaw = 'wide'; give a number from 0 to 4"),
    ],
)
def test_files_of_styles_that_are_damaged(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=message):
        read_styles(own(tmp_path, text))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=r"gone.toml: cannot be read: No such file"):
        read_styles(tmp_path / "gone.toml")


def test_a_line_is_made_again_when_its_style_changes(
    tmp_path: Path, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = table(tmp_path, "x,a.TextGrid,loud,\n")
    (tmp_path / "a.TextGrid").write_bytes((root / "examples/line.TextGrid").read_bytes())
    batch = ["batch", source, "-o", "out", "--styles", "styles.toml", "--fps", "25", "--workers", "1", "-q"]
    made = []
    for gain in (1.0, 0.5, 0.5):
        own(tmp_path, f"[loud]\njaw = {gain}\n")
        assert run(batch) == 0
        made.append((tmp_path / "out/x.csv").read_bytes())
    assert made[0] != made[1] == made[2]
    assert run(["audit", source, "--outputs", "out", "--styles", "styles.toml"]) == 0
    assert run(["audit", source, "--outputs", "out"]) == 1
