"""Sound that is made worse, and what a model costs: laws that hold for any recording and any model."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from speech import made_up_corpus, random_track, sound_of, write_wav

from phonanim.comparison import degradations, fit
from phonanim.comparison.conditions import ClipInput, align_clip, apply_condition, describe_conditions
from phonanim.comparison.cost import line_cost, look_ahead, training_cost
from phonanim.comparison.fit import Job
from phonanim.comparison.plan import Condition, Plan
from phonanim.corpus.corpus import Corpus
from phonanim.errors import ModelError
from phonanim.features.indicators import WIDTH
from phonanim.features.inputs import NO_CLUSTERS, n_features
from phonanim.media.audio import Sound, read_sound
from phonanim.regressors import Regressor, dnn
from phonanim.regressors.phone_mean import Config as MeanConfig
from phonanim.regressors.phone_mean import PhoneMean
from phonanim.speech.phones import PhoneTrack

RATE = 16000


def tone(hertz: float, begin: float = 0.0, end: float = 2.0) -> Sound:
    at = np.arange(2 * RATE) / RATE
    changed = np.where((at >= begin) & (at < end), 0.5 * np.sin(2 * np.pi * hertz * at), 0)
    return Sound(changed.astype(np.float32), RATE)


@pytest.fixture
def corpus(tmp_path: Path) -> Corpus:
    made_up = made_up_corpus(np.random.default_rng(5), clips=8)
    found = replace(made_up, audio=tuple(tmp_path / path for path in made_up.audio))
    for track, path in zip(found.tracks, found.audio, strict=True):
        write_wav(path, sound_of(track))
    return found


@pytest.mark.parametrize("semitones", [4, -4])
def test_a_voice_is_moved_and_keeps_its_time(semitones: float) -> None:
    changed = degradations.shift_voice(tone(150, 0.6, 1.3), semitones)
    assert changed.samples.shape == (2 * RATE,)
    strongest = np.argmax(np.abs(np.fft.rfft(changed.samples))) / 2
    assert strongest == pytest.approx(150 * 2 ** (semitones / 12), rel=0.01)
    loud = np.flatnonzero(np.abs(changed.samples) > 0.2) / RATE
    assert [loud[0], loud[-1]] == pytest.approx([0.6, 1.3], abs=degradations.SEARCH + 0.004)


def test_a_stretch_of_nothing_is_nothing_and_no_stretch_changes_nothing() -> None:
    assert not degradations.stretch_time(np.zeros(5000, np.float32), 7000, RATE).any()
    same = tone(150).samples
    found = degradations.stretch_time(same, len(same), RATE)
    np.testing.assert_allclose(found[: -RATE // 20], same[: -RATE // 20], atol=1e-6)  # then silence follows


@pytest.mark.parametrize("snr", [20, 0])
def test_noise_is_as_loud_as_was_asked_for(snr: float) -> None:
    speech, noise = tone(100, 0.5, 1.0), degradations.white_noise(2 * RATE, np.random.default_rng(0))
    spoken = np.zeros(2 * RATE, bool)
    spoken[RATE // 2 : RATE] = True
    changed = degradations.mix_noise(speech, noise, snr, spoken).samples
    assert np.abs(changed).max() <= 1
    quiet = changed[~spoken]
    scale = np.corrcoef(changed[spoken], speech.samples[spoken])[0, 1] if snr > 10 else 1
    assert scale > 0.98
    apart = np.linalg.lstsq(np.stack([speech.samples, noise], axis=1), changed, rcond=None)[0]
    power = (apart[0] * speech.samples[spoken]).var(), (apart[1] * noise).var()
    assert 10 * np.log10(power[0] / power[1]) == pytest.approx(snr, abs=0.05)
    assert quiet.std() == pytest.approx(apart[1], rel=0.05)


def test_babble_is_made_of_other_clips_and_of_the_seed(corpus: Corpus) -> None:
    clip = int(corpus.clips_of("test")[0])
    loud, soft = Condition(noise="babble", snr=0), Condition(noise="babble", snr=12)
    clean = read_sound(corpus.audio[clip]).samples
    changed = apply_condition(loud, 0, corpus, clip).samples
    assert (changed == apply_condition(loud, 0, corpus, clip).samples).all()
    assert not np.allclose(changed, apply_condition(loud, 1, corpus, clip).samples)
    assert (apply_condition(Condition(), 0, corpus, clip).samples == clean).all()

    def noise(samples: np.ndarray) -> np.ndarray:
        # Softened as a whole where it was too loud, so what is left of the clean sound is fitted first.
        silent = corpus.tracks[clip].sample(np.arange(len(clean)) / 8000) == 0
        return samples[silent & (clean == 0)]

    alike = np.corrcoef(noise(changed), noise(apply_condition(soft, 0, corpus, clip).samples))[0, 1]
    assert alike == pytest.approx(1, abs=1e-5)  # the same noise at another level


def test_alignments_are_kept(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pocketsphinx")
    sound = read_sound(root / "examples/line.wav")
    text = "My father watched Bob move a cheap blue lamp from the wash room."
    found = align_clip(sound, text, "line", tmp_path)
    assert found is not None
    assert len(found.codes) > 30
    monkeypatch.setattr("phonanim.aligners.pocketsphinx.align_sound", None)
    again = align_clip(sound, text, "line", tmp_path)
    assert again is not None
    assert (again.bounds == found.bounds).all()


def test_a_clip_that_cannot_be_aligned_rests(corpus: Corpus) -> None:
    track, sound = corpus.tracks[6], read_sound(corpus.audio[6])
    silent = PhoneTrack(np.zeros(1, np.uint8), track.bounds[[0, -1]], ("",))
    plan = Plan(Path(), {}, "", conditions={"well": Condition(), "ill": Condition()})
    changed = {"well": (ClipInput(6, sound, track, True),), "ill": (ClipInput(6, sound, silent, False),)}
    found = describe_conditions(plan, changed, corpus)
    assert (found["well"]["not_aligned"], found["well"]["other_phone"]) == (0, 0.0)
    assert (found["ill"]["not_aligned"], found["ill"]["other_phone"]) == (1, 1.0)


def network(features: str, width: int, reach: int = WIDTH) -> dnn.Network:
    config, rng = (
        dnn.Config(features=features, width=width, reach=reach, hidden=(8,)),
        np.random.default_rng(2),
    )
    sizes = n_features(features, reach), 8, 3 * width
    layers = [
        (rng.normal(size=shape).astype(np.float32), np.zeros(shape[1], np.float32))
        for shape in pairwise(sizes)
    ]
    return dnn.Network(config, (tuple(layers),), NO_CLUSTERS)


@pytest.mark.parametrize(
    ("model", "milliseconds"),
    [
        (network("raw", 1), 200),
        (network("raw", 3, reach=5), 120),
        (network("indicators", 3, reach=5), 120),
        (network("indicators", 5), 280),
        (PhoneMean(MeanConfig(0.12), np.arange(123, dtype=np.float32).reshape(41, 3)), 60),
    ],
)
def test_what_is_said_beyond_the_look_ahead_changes_nothing(model: Regressor, milliseconds: int) -> None:
    assert look_ahead(model) == str(milliseconds)
    track = random_track(np.random.default_rng(4), segments=30)
    times = np.arange(0, track.duration - 0.02, 0.005)
    there, seen = model.predict(track, times), []
    for cut in range(8, 26):
        codes = np.concatenate([track.codes[:cut], (track.codes[cut:] + 7) % 41])
        other = model.predict(PhoneTrack(codes, track.bounds, track.labels), times)
        first = np.argmax(np.abs(other - there).max(axis=1) > 1e-4)
        seen.append(track.bounds[cut] - times[first])
    assert milliseconds / 1000 - 0.01 < max(seen) <= milliseconds / 1000 + 1e-6


def test_other_look_aheads(root: Path) -> None:
    from phonanim import regressors

    shipped = regressors.load(root / "phonanim/models/default").regressor
    assert look_ahead(shipped) == "800 and 3 phones"


def test_a_line_costs_time_and_memory(root: Path, corpus: Corpus) -> None:
    found = line_cost(root / "phonanim/models/default", corpus, 0)
    assert 0 < found["line_ms"] < 1000
    assert 1 < found["memory_mb"] < 500


def test_a_plugin_that_fails_in_a_process_of_its_own_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(job: Job) -> None:
        raise ValueError("no rows")

    job = Job(Path("r.toml"), Path("corpus"), (), (), Path("work"))
    monkeypatch.setattr(fit, "train_job", broken)
    with pytest.raises(ValueError, match="no rows"):  # of phonanim itself: its trace is kept
        fit.train_in_worker(job)
    monkeypatch.setattr("phonanim.core.plugins.find_culprit", lambda trace: "plugin 'mine' (mine 1.0)")
    wanted = r"r.toml: plugin 'mine' \(mine 1.0\) failed: ValueError: no rows; update or uninstall it"
    with pytest.raises(ModelError, match=wanted):
        fit.train_in_worker(job)


def test_trainings_are_counted_once(tmp_path: Path) -> None:
    jobs = []
    for name, seconds in (("a", 90.0), ("b", 30.0), ("a", 90.0)):
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / name / "job.json").write_text(json.dumps({"key": name, "seconds": seconds}))
        jobs.append(Job(Path("r.toml"), Path("corpus"), (), (), tmp_path / name))
    assert training_cost(jobs) == {"jobs": 2, "training_s": 120.0, "longest_s": 90.0}
