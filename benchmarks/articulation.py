"""Articulation against real mouths: sensors, recorded lips, and what each phone looks like in natural text.

    phonanim corpus build RECORDINGS -o work/corpus
    python benchmarks/articulation.py work/corpus --ema RECORDINGS/ema_de --ema RECORDINGS/ema_en \\
        --text RECORDINGS/textgrids/ljspeech_mfa_3000.tar.xz

Sensors: targets are fitted anew without the sentence, and without the speaker, that they are compared with;
r and sd are those of speech, a mean over sentences. "in sample" is a fit that has seen the sentence and may
go far from its prior: what targets of phones, blended, can reach at all. Sigma, lead and freedom are those
that scripts/fit_articulation.py chose on the same sentences.
"""

from __future__ import annotations

import sys
import tarfile
import tempfile
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from articulation_data import lip_observations, observations  # noqa: E402
from fit_articulation import PRIOR, RULED, fit, folds, scaled, settings_of  # noqa: E402

from phonanim.articulation import CHANNELS, articulate  # noqa: E402
from phonanim.articulation.blend import blend_articulation, lip_channels  # noqa: E402
from phonanim.articulation.fitting import Channel, Observation  # noqa: E402
from phonanim.articulation.table import CHANNELS_FILE, read_targets  # noqa: E402
from phonanim.corpus.corpus import load_corpus  # noqa: E402
from phonanim.ema.channels import Recording, load_recordings  # noqa: E402
from phonanim.inputs.alignment import read_alignment  # noqa: E402
from phonanim.metrics import correlation, speech_mask  # noqa: E402
from phonanim.pipeline import load_model  # noqa: E402
from phonanim.regressors import Model  # noqa: E402
from phonanim.rig.motion import closed_face, read_motion  # noqa: E402
from phonanim.speech.inventory import INVENTORY  # noqa: E402
from phonanim.speech.language import to_phones  # noqa: E402
from phonanim.speech.phones import PhoneTrack  # noqa: E402

Array = NDArray[np.float64]
LIPS = ("lip_gap", "lip_width", "protrusion", "upper_lip")
LOOSE = {"target": 5.0, "weight": 1.0}
SHOWN = ("lip_gap", "lip_width", "protrusion", "jaw", "lower_lip_to_teeth")
FPS = 60.0
MIDDLE = 0.3  # share of a phone, around its middle, that the phone table looks at
SIBILANTS = ("s", "z", "sh", "ch", "jh")


def sensor_rows(recordings: list[Recording], corpus: Path) -> None:
    """A table of left-out fits against sensors."""
    speakers = sorted({one.speaker for one in recordings})
    print(f"| channel | left out | {' | '.join(f'{s}: r (least), sd ratio' for s in speakers)} | mean r |")
    print("|---|---|" + "---|" * len(speakers) + "---:|")
    prior, settings = read_targets(PRIOR), settings_of(CHANNELS_FILE)
    for number, name in enumerate(CHANNELS):
        if name == RULED:
            continue
        start = Channel(prior.target[:, number], prior.weight[:, number], 0.0, 0.0)
        seen = observations(recordings, name) + lip_observations(corpus, name)
        left: dict[str, list[tuple[Channel, list[Observation]]]] = {"sentence": [], "speaker": []}
        for kind, fitted, group in folds(seen, start, settings[name]):
            if kind == "camera":
                continue
            kept = [one for one in recordings if one.name not in {other.name for other in group}]
            left[kind].append((scaled(name, fitted, kept), group))
        everything = fit(seen, start, settings[name] | LOOSE)
        left["in sample"] = [(everything, [one for one in seen if one.share == 1])]
        for kind, fits in left.items():
            print(sensor_row(f"| {name} | {kind} ", fits, speakers), flush=True)


def sensor_row(label: str, fits: list[tuple[Channel, list[Observation]]], speakers: list[str]) -> str:
    """R and the ratio of standard deviations by speaker, and r over all sentences."""
    found: dict[str, list[tuple[float, float]]] = {speaker: [] for speaker in speakers}
    for fitted, group in fits:
        for one in group:
            curve = fitted.predict(one.track, one.times)
            ratio = curve.std() / one.values.std() if one.in_mm else np.nan
            found[one.speaker].append((correlation(curve, one.values), ratio))
    cells = [
        f"{np.mean([r for r, _ in rows]):.2f} ({min(r for r, _ in rows):.2f})"
        + ("" if np.isnan(rows[0][1]) else f", {np.mean([sd for _, sd in rows]):.2f}")
        if rows
        else ""
        for rows in found.values()
    ]
    total = np.mean([r for rows in found.values() for r, _ in rows])
    return f"{label}| {' | '.join(cells)} | {total:.3f} |"


def lip_rows(folder: Path, model: Model, closed: Array) -> None:
    """A table of recorded lips in the test clips: the learned face, targets, and both."""
    corpus = load_corpus(folder)
    ways: dict[str, list[dict[str, Array]]] = {"captured": [], "learned": [], "targets": [], "both": []}
    rest = {name: curve[0] for name, curve in lip_channels(closed[None], model.face).items()}
    for clip in corpus.clips_of("test"):
        track, times = corpus.tracks[clip], corpus.times(clip)
        said = speech_mask(track, times)
        shapes = model.face.instance(model.regressor.predict(track, times, None))
        both = blend_articulation(shapes, model.face, closed, track, times)
        captured = corpus.landmarks[corpus.rows([clip])].astype(np.float64)
        for way, motion in (("captured", captured), ("learned", shapes)):
            found = lip_channels(motion, model.face)
            ways[way].append({name: found[name][said] - rest[name] for name in LIPS})
        for way, values in (("targets", articulate(track, times)), ("both", both)):
            ways[way].append({name: values.channel(name)[said] for name in LIPS})
    print("\n| channel | way | r in speech | slope | sd ratio |\n|---|---|---:|---:|---:|")
    for name in LIPS:
        curves = {way: np.concatenate([one[name] for one in parts]) for way, parts in ways.items()}
        wanted = curves.pop("captured")
        for way, curve in curves.items():
            slope = np.polyfit(wanted, curve, 1)[0]
            r, ratio = correlation(curve, wanted), curve.std() / wanted.std()
            print(f"| {name} | {way} | {r:.3f} | {slope:.2f} | {ratio:.2f} |")


def natural_tracks(archive: Path, lines: int) -> list[PhoneTrack]:
    """Phones of alignments in an archive, spread over it."""
    tracks = []
    with tarfile.open(archive) as stored, tempfile.TemporaryDirectory() as folder:
        names = sorted(name for name in stored.getnames() if name.endswith(".TextGrid"))
        for name in names[:: max(len(names) // lines, 1)][:lines]:
            member = stored.extractfile(name)
            path = Path(folder) / Path(name).name
            path.write_bytes(member.read() if member else b"")
            tracks.append(to_phones(read_alignment(path), "english")[0])
    return tracks


def phone_means(tracks: list[PhoneTrack], model: Model, closed: Array) -> dict[str, dict[str, float]]:
    """Mean of each channel in the middle of each phone, mm, by the learned face and targets together."""
    codes, values = [], []
    for track in tracks:
        frames = int(track.duration * FPS) + 1
        times = np.arange(frames) / FPS
        shapes = model.face.instance(model.predict(track, FPS, frames))
        moved = blend_articulation(shapes, model.face, closed, track, times).values
        at = track.segment_at(times)
        begin, end = track.bounds[at], track.bounds[at + 1]
        near = np.abs(times - (begin + end) / 2) <= MIDDLE / 2 * (end - begin) + 0.5 / FPS
        codes.append(track.codes[at][near])
        values.append(moved[near])
    code, table = np.concatenate(codes), np.concatenate(values)
    places = [CHANNELS.index(name) for name in SHOWN]
    return {
        phone: dict(zip(SHOWN, table[code == number][:, places].mean(axis=0), strict=True))
        for number, phone in enumerate(INVENTORY.phones)
        if (code == number).any()
    }


def phone_rows(means: dict[str, dict[str, float]]) -> None:
    """The phone table, and what it must reach."""
    print(f"\n| phone | {' | '.join(SHOWN)} |\n|---|" + "---:|" * len(SHOWN))
    for phone, row in means.items():
        print(f"| {phone} | {' | '.join(f'{row[name]:.1f}' for name in SHOWN)} |")
    closed = min(row["jaw"] for row in means.values())
    jaw = {phone: row["jaw"] - closed for phone, row in means.items()}
    teeth = [means[phone]["jaw"] for phone in SIBILANTS]
    iy, aa, uw = (means[phone] for phone in ("iy", "aa", "uw"))
    checks = [
        ("lip gap AA / IY", aa["lip_gap"] / iy["lip_gap"], ">= 1.3"),
        ("jaw AA / IY", jaw["aa"] / jaw["iy"], ">= 2.5"),
        ("jaw AA / s z sh ch jh", aa["jaw"] / np.mean(teeth), ">= 4"),
        ("UW narrower than IY, mm", iy["lip_width"] - uw["lip_width"], ">= 7"),
        ("UW further out than IY, mm", uw["protrusion"] - iy["protrusion"], ">= 4"),
        ("teeth apart at s z sh ch jh, mm, most", max(teeth), "<= 1.5"),
        ("lower lip from teeth at f v, mm", max(means[p]["lower_lip_to_teeth"] for p in "fv"), "<= 1"),
        ("gap at p b m, mm, most", max(means[p]["lip_gap"] for p in "pbm"), "<= 0.5"),
    ]
    print("\n| check | is | wanted |\n|---|---:|---|")
    for label, value, wanted in checks:
        print(f"| {label} | {value:.2f} | {wanted} |")


@click.command(help=__doc__)
@click.argument("corpus", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--ema", multiple=True, type=click.Path(exists=True, path_type=Path), help="Sensors; repeat.")
@click.option("--text", type=click.Path(exists=True, path_type=Path), help="An archive of alignments.")
@click.option("--lines", default=300, show_default=True, help="Alignments of the archive to use.")
@click.option("--model", "name", default="default", show_default=True)
def main(corpus: Path, ema: tuple[Path, ...], text: Path | None, lines: int, name: str) -> None:
    """The tables that were asked for."""
    model = load_model(name)
    closed = closed_face(model.face, read_motion().modes(model.face))
    if ema:
        sensor_rows([one for folder in ema for one in load_recordings(folder)], corpus)
    lip_rows(corpus, model, closed)
    if text:
        phone_rows(phone_means(natural_tracks(text, lines), model, closed))


if __name__ == "__main__":
    main()
