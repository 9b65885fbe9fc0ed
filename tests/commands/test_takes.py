"""Models that sample: takes, seeds, steps, guidance and styles; features of another program."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from speech import made_up_examples, made_up_face, write_wav

import phonanim
from phonanim.__main__ import run
from phonanim.encoders.precomputed import SUFFIX, read_features
from phonanim.errors import AudioError, ModelError, OptionError
from phonanim.media.audio import Sound, read_sound
from phonanim.regressors import Model, make_config, regressor_class, save

pytest.importorskip("torch")
SMALL: dict[str, Any] = {
    **{"latent": 4, "hidden": 8, "depth": 1, "timesteps": 10, "steps": 3, "styles": 2},
    **{"window": 20, "batch": 6, "epochs": 1, "learning_rate": 0.1},
}


def trained(kind: str, folder: Path, encoder: str, **more: Any) -> Path:
    """A model of made-up clips; with the encoder `precomputed`, of features in files."""
    rng = np.random.default_rng(5)
    styles = tuple(clip % more.get("styles", 1) for clip in range(4))
    data = replace(made_up_examples(rng, clips=4), styles=styles)
    if encoder == "precomputed":
        sounds = []
        for number, sound in enumerate(data.sounds):
            path = folder / f"clip{number}{SUFFIX}"
            np.save(path, rng.normal(size=(round(sound.duration * 50), 6)))
            sounds.append(replace(sound, features=path))
        data = replace(data, sounds=tuple(sounds))
    config = make_config(kind, {"encoder": encoder} | more, "test")
    fit: Any = regressor_class(kind).fit
    regressor = fit(config, data, data, rng, lambda done: None)
    save(Model(regressor, made_up_face(rng), {"fps": 25.0}), folder / "model")
    return folder / "model"


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return trained("facediffuser", tmp_path_factory.mktemp("sampled"), "mfcc", **SMALL)


@pytest.fixture
def wav(tmp_path: Path) -> Path:
    path = tmp_path / "line.wav"
    samples = np.sin(np.cumsum(np.linspace(0.1, 0.9, 9600))).astype(np.float32) * 0.3
    write_wav(path, Sound(samples, 8000))
    return path


def animated(wav: Path, model: Path, name: str, *options: str) -> bytes:
    output = wav.with_name(name)
    command = ["animate", str(wav), "--model", str(model), "-o", str(output), "--life", "0", "-q"]
    assert run([*command, *options]) == 0
    return output.read_bytes() if output.exists() else b""


def test_takes_are_those_of_the_next_seeds(wav: Path, model: Path) -> None:
    animated(
        wav, model, "line.csv", "--takes", "2", "--seed", "3", "--contact-sheet", str(wav.with_suffix(".png"))
    )
    assert sorted(path.name for path in wav.parent.iterdir()) == [
        *("line.take1.csv", "line.take1.png", "line.take2.csv", "line.take2.png", "line.wav")
    ]
    first, second = (wav.with_name(f"line.take{n}.csv").read_bytes() for n in (1, 2))
    assert first != second
    assert animated(wav, model, "one.csv", "--seed", "3") == first
    assert animated(wav, model, "two.csv", "--seed", "4") == second


def test_every_setting_changes_the_take_and_is_kept_with_it(wav: Path, model: Path) -> None:
    plain = animated(wav, model, "plain.csv")
    for number, option in enumerate((("--steps", "9"), ("--guidance", "0.4"), ("--style", "1"))):
        assert animated(wav, model, f"{number}.csv", *option) != plain
    made = phonanim.animate(wav, model=str(model), seed=2, guidance=0.5, style=1)
    kept = made.provenance["options"]
    assert (kept["seed"], kept["guidance"], kept["model_style"]) == (2, 0.5, 1)
    assert "steps" not in kept
    assert "seed" not in phonanim.animate(wav, model=str(model)).provenance["options"]


def test_takes_are_listed_as_data(wav: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["animate", str(wav), "--model", str(model), "-o", str(wav.with_name("x.track.json"))]
    assert run([*command, "--takes", "2", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    named = [Path(take["outputs"][0]["path"]).name for take in facts["takes"]]
    assert named == ["x.take1.track.json", "x.take2.track.json"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--seed", "1"], "the model default does not sample: leave out --seed"),
        (["--takes", "2"], "the model default does not sample: leave out --takes"),
        (["--style", "1"], "the model default has no styles: leave out --style"),
    ],
)
def test_other_models_do_not_sample(
    options: list[str], said: str, root: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = str(root / "examples" / "line.TextGrid")
    assert run(["animate", line, "-o", str(tmp_path / "x.csv"), *options]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_ablation_has_one_take(wav: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = trained("facediffuser", tmp_path, "mfcc", **SMALL | {"diffusion": False, "styles": 1})
    command = ["animate", str(wav), "--model", str(model), "-o", str(wav.with_name("x.csv"))]
    for option in ("--seed", "--steps", "--guidance", "--takes"):
        assert run([*command, option, "2"]) == 2
        assert f"does not sample: leave out {option}" in capsys.readouterr().err
    assert run([*command, "--style", "0"]) == 2
    assert "has no styles: leave out --style" in capsys.readouterr().err


def test_values_that_a_model_does_not_take(wav: Path, model: Path) -> None:
    with pytest.raises(ModelError, match="there is no style 2; take 0 to 1"):
        phonanim.animate(wav, model=str(model), style=2)
    with pytest.raises(ModelError, match="steps is 11; take 1 to 10"):
        phonanim.animate(wav, model=str(model), steps=11)
    with pytest.raises(OptionError, match="does not sample"):
        phonanim.animate(wav, guidance=0.5)
    with pytest.raises(OptionError, match="reads no precomputed features: leave out --features"):
        phonanim.animate(wav, model=str(model), features=wav)


@pytest.mark.parametrize(
    ("kind", "more"), [("facediffuser", SMALL), ("phisanet", {"hidden": 8, "depth": 1, "epochs": 1})]
)
def test_features_of_another_program_are_an_encoder(
    kind: str, more: dict[str, Any], wav: Path, tmp_path: Path
) -> None:
    model, rng = trained(kind, tmp_path, "precomputed", **more), np.random.default_rng(0)
    steps = round(read_sound(wav).duration * 100)  # another rate than in training
    np.save(tmp_path / "given.npy", rng.normal(size=(steps, 6)))
    np.save(wav.with_suffix(SUFFIX), rng.normal(size=(steps, 6)))
    given = animated(wav, model, "given.csv", "--features", str(tmp_path / "given.npy"))
    beside = animated(wav, model, "beside.csv")
    assert given != beside
    np.save(wav.with_suffix(SUFFIX), np.load(tmp_path / "given.npy"))
    assert animated(wav, model, "again.csv") == given
    np.save(tmp_path / "wide.npy", np.zeros((steps, 7)))
    with pytest.raises(ModelError, match=r"wide\.npy: has 1 layers of 7 features, .* trained with 1 of 6"):
        phonanim.animate(wav, model=str(model), features=tmp_path / "wide.npy")


def test_features_are_at_the_rate_that_covers_the_recording(tmp_path: Path) -> None:
    sound = Sound(np.zeros(16000, np.float32), 8000, tmp_path / "f.npy")
    for rate, steps in ((50.0, 98), (100.0, 200), (30.0, 61), (25.0, 50)):
        np.save(tmp_path / "f.npy", np.zeros((steps, 2, 3)))
        found = read_features(sound)
        assert (found.rate, found.start) == (rate, 0.5 / rate)
        assert found.values.shape == (steps, 2, 3)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (
            None,
            "there is no such file; put them beside it as NAME.features.npy, or name them with --features",
        ),
        (np.zeros((70, 3)), "has 70 steps for 1.00 s of sound; give 25, 30, 50, 60, 100 per second"),
        (np.zeros(50), r"must hold numbers of the shape \(steps, dims\)"),
        (np.full((50, 3), np.nan), "has numbers that are not finite"),
        (np.array([["a"]]), "must hold numbers"),
        (b"no array", "cannot be read as an array"),
    ],
)
def test_files_that_are_no_features(values: Any, said: str, tmp_path: Path) -> None:
    path = tmp_path / "f.npy"
    if isinstance(values, bytes):
        path.write_bytes(values)
    elif values is not None:
        np.save(path, values)
    with pytest.raises(AudioError, match=said):
        read_features(Sound(np.zeros(8000, np.float32), 8000, path))
    with pytest.raises(AudioError, match="the recording has no file of features"):
        read_features(Sound(np.zeros(8000, np.float32), 8000))


def test_samples_alone_have_no_precomputed_features() -> None:
    from phonanim.encoders import load_encoder

    with pytest.raises(AudioError, match="precomputed features belong to a file"):
        load_encoder("precomputed").run(np.zeros(320, np.float32))
