import json
import shutil

import pytest

from phonanim.__main__ import run
from phonanim.core.catalog import DEFAULT_MODEL, SHIPPED, find_model, list_models, read_card
from phonanim.errors import ModelError


@pytest.fixture
def local(tmp_path, monkeypatch):
    """A folder of local models with one model, `mine`."""
    monkeypatch.setenv("PHONANIM_MODELS", str(tmp_path))
    shutil.copytree(SHIPPED / DEFAULT_MODEL, tmp_path / "mine")
    return tmp_path


def test_by_name_and_by_path(local, monkeypatch):
    assert find_model(DEFAULT_MODEL) == SHIPPED / DEFAULT_MODEL
    assert find_model("mine") == local / "mine"
    assert find_model(str(local / "mine")) == local / "mine"
    monkeypatch.delenv("PHONANIM_MODELS")
    monkeypatch.chdir(local.parent)
    local.rename(local.parent / "models")
    assert find_model("mine").resolve() == local.parent / "models" / "mine"


def test_shipped_models_come_first(local):
    entries = list_models()
    assert entries[-1].name == "mine"
    assert [entry.shipped for entry in entries] == [True] * (len(entries) - 1) + [False]


def test_no_such_model(local):
    with pytest.raises(
        ModelError, match=r"there is no model 'mime'; did you mean 'mine'\?; `phonanim models`"
    ):
        find_model("mime")
    with pytest.raises(
        ModelError, match="there is no model 'xyzzy'; `phonanim models` lists the available ones"
    ):
        find_model("xyzzy")


def test_damaged_cards(local):
    (local / "mine/model.json").write_text("{")
    with pytest.raises(
        ModelError, match=r"mine/model.json: cannot be read .*; fetch or train the model again"
    ):
        read_card(local / "mine")
    (local / "mine/model.json").write_text("[]")
    with pytest.raises(ModelError, match=r"mine/model.json: is not a JSON object"):
        read_card(local / "mine")


def test_models_as_text_and_as_json(local, capsys):
    assert run(["models"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [entry.name for entry in list_models()]
    assert run(["models", "--json"]) == 0
    models = json.loads(capsys.readouterr().out)
    assert models[-1]["name"] == "mine"
    assert {"path", "shipped", "kind"} <= set(models[0])


def test_the_shipped_models_are_small():
    size = sum(path.stat().st_size for path in SHIPPED.rglob("*") if path.is_file())
    assert size <= 8e6
