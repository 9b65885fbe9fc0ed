"""Means of models whose members have learned styles: all are in the same one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples
from styled_models import spoken_by, trained_on

import phonanim
from phonanim.errors import ModelError
from phonanim.pipeline import load_model
from phonanim.regressors import Examples, make_config, regressor_class

pytest.importorskip("torch")
pytest.importorskip("sklearn")
AUDIO = {"kind": "two_stage", "encoder": "mfcc", "hidden": 8, "depth": 1, "epochs": 2, "window": 20}
TREE = {"kind": "tree", "leaf": 1, "width": 1, "features": "raw"}
MEMBERS: dict[str, list[dict[str, Any]]] = {
    "ensemble": [{"kind": "phone_mean", "weight": 3.0}, TREE],
    "late_fusion": [{"kind": "phone_mean", "weight": 3.0}, AUDIO],
}
RECIPE = """
kind = "ensemble"
[[settings.members]]
kind = "phone_mean"
[[settings.members]]
kind = "tree"
leaf = 4
"""


@pytest.fixture(scope="module")
def data() -> Examples:
    """The same clips by two speakers, the second of whom holds the face otherwise."""
    one = made_up_examples(np.random.default_rng(5), clips=4)
    both = one + replace(one, targets=tuple(target + np.float32(2) for target in one.targets))
    return replace(both, styles=(0,) * 4 + (1,) * 4)


def fitted(kind: str, data: Examples, members: list[dict[str, Any]]) -> Any:
    config = make_config(kind, {"members": members}, "test")
    return regressor_class(kind).fit(config, data, data, np.random.default_rng(1), lambda done: None)


@pytest.mark.parametrize("kind", MEMBERS)
def test_a_style_is_passed_on_to_all_members(kind: str, data: Examples) -> None:
    model = fitted(kind, data, [{**member, "styles": 2} for member in MEMBERS[kind]])
    again = type(model).from_tensors(model.config, model.tensors())
    second = again.with_settings(style=1)
    stored = type(model).from_tensors(second.config, second.tensors())
    given = data.tracks[0], data.times[0], data.sounds[0]
    assert (again.config.styles, again.config.style, second.config.style) == (2, 0, 1)
    parts = [member.with_settings(style=1).predict(*given) for member in again.members]
    expected = np.average(parts, axis=0, weights=again.weights)
    for one in (second, stored):
        np.testing.assert_allclose(one.predict(*given), expected, rtol=1e-6)
    assert np.array_equal(again.with_settings(style=0).predict(*given), model.predict(*given))
    assert (second.predict(*given) - model.predict(*given)).mean() > 1


def test_a_member_of_one_style_learns_all_as_one(data: Examples) -> None:
    first, other = MEMBERS["ensemble"]
    model = fitted("ensemble", data, [{**first, "styles": 2}, {**other, "styles": 1}])
    changed = model.with_settings(style=1)
    assert changed.members[1] is model.members[1]
    assert [member.config.style for member in changed.members] == [1, 0]


def test_styles_that_are_not_there(data: Examples) -> None:
    styled = fitted("ensemble", data, [{**member, "styles": 2} for member in MEMBERS["ensemble"]])
    with pytest.raises(ModelError, match="phone_mean: there is no style 2; take 0 to 1"):
        styled.with_settings(style=2)
    with pytest.raises(ModelError, match="does not sample: leave out --seed"):
        styled.with_settings(seed=1)
    plain = fitted("ensemble", data, MEMBERS["ensemble"])
    assert plain.config.styles == 1
    with pytest.raises(ModelError, match="the models have no styles: leave out --style"):
        plain.with_settings(style=0)
    fixed = replace(styled, members=(object(), styled.members[1]))
    with pytest.raises(ModelError, match="the member phone_mean has no with_settings, by which its style"):
        fixed.with_settings(style=1)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([{"styles": 2}, {"styles": 3}], "test: members have styles = 2 and 3; give all the same one"),
        (
            [{"styles": 2, "style": 1}, {"styles": 2}],
            "test: members have style = 0 and 1; give all the same one",
        ),
    ],
)
def test_members_that_do_not_agree(changes: list[dict[str, int]], said: str) -> None:
    members = [table | change for table, change in zip(MEMBERS["ensemble"], changes, strict=True)]
    with pytest.raises(ModelError, match=said):
        make_config("ensemble", {"members": members}, "test")


def test_a_member_without_a_kind() -> None:
    with pytest.raises(ModelError, match="test: a member has no kind; give each one"):
        make_config("ensemble", {"members": [{"weight": 1.0}]}, "test")


def test_an_ensemble_learns_the_speakers_of_a_corpus(
    tmp_path: Path, root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corpus, line = spoken_by(("anna", "bert"), tmp_path), root / "examples/line.TextGrid"
    assert trained_on(corpus, RECIPE) == 0
    assert "styles, for --style: anna, bert" in capsys.readouterr().err
    name = str(tmp_path / "model")
    assert load_model(name).card["styles"] == ["anna", "bert"]
    assert [member["styles"] for member in load_model(name).regressor.config.members] == [2, 2]
    anna, bert = (
        phonanim.animate(line, model=name, style=style, fps=25).values for style in ("anna", "bert")
    )
    assert not np.array_equal(anna, bert)
    assert np.array_equal(anna, phonanim.animate(line, model=name, fps=25).values)
    for number, extra in enumerate(("styles = 1", "styles = 5")):
        code = trained_on(corpus, f"{RECIPE}{extra}", f"other{number}")
        said = capsys.readouterr().err
        assert code == (2 if number else 0), said
    assert "other1.toml: members have styles = 2 and 5; give all the same one" in said


def test_an_ensemble_without_members_of_a_kind_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corpus = spoken_by(("anna", "bert"), tmp_path)
    assert trained_on(corpus, 'kind = "ensemble"\nsettings = {members = [{leaf = 4}]}') == 2
    assert "model.toml: a member has no kind" in capsys.readouterr().err
