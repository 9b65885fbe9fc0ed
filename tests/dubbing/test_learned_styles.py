"""Styles that a model has learned: by name, by number, and beside presets of the same name."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from styled_models import spoken_by, trained_on

import phonanim
from phonanim.__main__ import run
from phonanim.articulation.styles import ChosenStyle, choose_style, read_styles, spell_learned
from phonanim.errors import OptionError
from phonanim.exporters import load

SPEAKERS = ("0", "Clear", "anna", "clear")  # sorted, as a model numbers them
Batch = Callable[..., int]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    corpus = spoken_by(SPEAKERS[::-1], tmp_path_factory.mktemp("styled"))
    assert trained_on(corpus, 'kind = "phone_mean"') == 0
    return corpus.with_name("model")


@pytest.fixture
def line(tmp_path: Path, root: Path) -> Path:
    (tmp_path / "a.TextGrid").write_bytes((root / "examples/line.TextGrid").read_bytes())
    return tmp_path / "a.TextGrid"


@pytest.fixture
def batch(line: Path, model: Path, monkeypatch: pytest.MonkeyPatch) -> Batch:
    """Makes a table of lines with the columns id, style, jaw and model in out/."""
    monkeypatch.chdir(line.parent)

    def run_table(rows: str, *options: str) -> int:
        cells = [row.split(",") for row in rows.split()]
        listed = [f"{id},{line.name},{style},{jaw},{name}" for id, style, jaw, name in cells]
        Path("t.csv").write_text("\n".join(("id,alignment,style,jaw,model", *listed)), "utf-8")
        return run(["batch", "t.csv", "-o", "out", "--format", "npz", "--workers", "1", *options])

    return run_table


def moved(line: Path, model: Path, style: int) -> np.ndarray:
    return phonanim.animate(line, model=str(model), model_style=style).values


def test_a_name_is_a_preset_before_it_is_a_learned_style(model: Path) -> None:
    presets, name = read_styles(), str(model)
    assert choose_style("anna", name, presets) == ChosenStyle("anna", 2)
    assert choose_style("learned:clear", name, presets) == ChosenStyle("learned:clear", 3)
    assert choose_style("learned:0", name, presets) == ChosenStyle("learned:0", 0)
    assert choose_style("0", name, presets) == ChosenStyle("0", 0)
    found = choose_style("clear", name, presets)
    assert (found.number, found.dials) == (None, presets["clear"])
    assert found.note == (
        "this is the preset 'clear'; the style of that name that the model has learned is "
        "learned:Clear or learned:clear"
    )
    assert spell_learned(SPEAKERS, presets) == ("0", "learned:Clear", "anna", "learned:clear")
    assert spell_learned(("1", "learned:1"), presets) == ("learned:1", "learned:learned:1")


def test_a_number_is_a_number_before_it_is_a_name(model: Path, tmp_path: Path) -> None:
    card = json.loads((model / "model.json").read_text("utf-8")) | {"styles": ["7", "0"]}
    (tmp_path / "model.json").write_text(json.dumps(card), "utf-8")
    found = choose_style("0", str(tmp_path), read_styles())
    assert (found.number, found.note.partition(";")[0]) == (0, "this is style number 0")
    assert choose_style("learned:0", str(tmp_path), read_styles()) == ChosenStyle("learned:0", 1)


@pytest.mark.parametrize(
    ("style", "said"),
    [
        ("learned:ana", "has learned no style 'ana'; did you mean 'anna'?"),
        ("learned:?", "has learned no style '?'; choose 0, Clear, anna, clear"),
    ],
)
def test_a_style_that_was_not_learned(style: str, said: str, model: Path) -> None:
    with pytest.raises(OptionError) as raised:
        choose_style(style, str(model), read_styles())
    assert str(raised.value).endswith(said)
    with pytest.raises(OptionError, match="the model default has learned no style 'F2'; it has no named"):
        choose_style("learned:F2", "default", read_styles())


def test_the_command_says_once_what_else_a_name_means(
    line: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def spoken(style: str, *more: str) -> tuple[np.ndarray, str]:
        output = line.with_suffix(".npz")
        command = ["animate", str(line), "--model", str(model), "-o", str(output), "--style", style]
        assert run([*command, *more]) == 0
        return load(output).values, capsys.readouterr().err

    learned, said = spoken("learned:clear")
    assert np.array_equal(learned, moved(line, model, 3))
    assert "this is" not in said
    preset, said = spoken("clear")
    assert np.array_equal(preset, moved(line, model, 0))
    assert said.count("--style clear: this is the preset 'clear'; ") == 1
    assert "this is" not in spoken("clear", "--quiet")[1]
    assert np.array_equal(phonanim.animate(line, model=str(model), style="learned:clear").values, learned)


def test_training_prints_the_names_that_are_not_mistaken(
    model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert trained_on(model.with_name("corpus"), 'kind = "phone_mean"', "again") == 0
    assert "styles, for --style: 0, learned:Clear, anna, learned:clear" in capsys.readouterr().err


def test_a_cell_names_a_style_that_the_model_of_its_line_has_learned(
    batch: Batch, line: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = f"x,anna,,{model} y,3,,{model} z,learned:clear,,{model} p,clear,,{model} q,clear,,"
    assert batch(rows) == 0
    made = {name: load(Path(f"out/{name}.npz")) for name in "xyzpq"}
    for name, style in {"x": 2, "y": 3, "z": 3, "p": 0}.items():
        assert np.array_equal(made[name].values, moved(line, model, style)), name
    assert made["q"].provenance["options"]["jaw"] == read_styles()["clear"]["jaw"]
    assert capsys.readouterr().err.count("style clear: this is the preset 'clear'") == 1
    assert run(["audit", "t.csv", "--outputs", "out"]) == 0


def test_rows_whose_style_is_not_there(batch: Batch, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert batch(f"x,ana,,{model} y,9,,{model} z,1,, v,learned:ana,, w,anna,,nowhere k,anna,,{model}") == 1
    said = capsys.readouterr().err
    for row, why in {
        2: "there is no style 'ana'; did you mean 'anna'?",
        3: "phone_mean: there is no style 9; take 0 to 3",
        4: "the model default has no styles: leave out --style",
        5: "the model default has learned no style 'ana'; it has no named styles",
        6: "there is no model 'nowhere'",
    }.items():
        assert f"t.csv row {row}: {why}" in said
    assert [path.name for path in Path("out").glob("*.npz")] == ["k.npz"]


def test_a_row_overrides_the_style_of_the_run(
    batch: Batch, line: Path, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    for file in model.iterdir():
        (other / file.name).write_bytes(file.read_bytes())
    card = json.loads((other / "model.json").read_text("utf-8")) | {"styles": ["bert", "anna", "0", "1"]}
    (other / "model.json").write_text(json.dumps(card), "utf-8")
    rows = f"x,,, y,clear,, z,learned:clear,, o,,,{other} d,,,default"
    assert batch(rows, "--model", str(model), "--style", "anna") == 1
    for name, folder, style in (("x", model, 2), ("y", model, 0), ("z", model, 3), ("o", other, 1)):
        assert np.array_equal(load(Path(f"out/{name}.npz")).values, moved(line, folder, style)), name
    assert "t.csv row 6: there is no style 'anna'" in capsys.readouterr().err
    assert run(["audit", "t.csv", "--outputs", "out", "--model", str(model), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)["findings"]
    assert [(one["problem"], one["id"]) for one in found] == [("missing", "d")]
