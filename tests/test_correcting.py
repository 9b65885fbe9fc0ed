"""`phonanim animate --edits` with corrections: lips held and parted, phones changed, curves redrawn."""

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.animation.correction_file import write_corrections
from phonanim.animation.corrections import Corrections
from phonanim.animation.edits import Edit, Edits
from phonanim.articulation import CHANNELS
from phonanim.correcting import animate_corrected, apply_line_edits
from phonanim.exporters import load
from phonanim.inputs.alignment import read_alignment
from phonanim.options import Closure, Options
from phonanim.pipeline import animate_detailed
from phonanim.rig import load_rig
from phonanim.speech.alignment import Interval
from phonanim.speech.phone_changes import PhoneChanges

GAP = CHANNELS.index("lip_gap")


@pytest.fixture(scope="module")
def line(root):
    return root / "examples/line.TextGrid"


@pytest.fixture(scope="module")
def phones(line):
    return read_alignment(line).intervals


def place(phones, label):
    return next(number for number, phone in enumerate(phones) if phone.label == label)


def gap_in(animation, start, end):
    inside = (animation.times >= start) & (animation.times <= end)
    return animation.articulation[inside, GAP]


@pytest.mark.parametrize("rig", ["arkit", "metahuman", "vrm"])
def test_lips_are_held_and_kept_apart(line, phones, rig):
    m, aa = phones[place(phones, "M")], phones[place(phones, "AA")]
    closures = (Closure("release", m.start, m.end), Closure("hold", aa.start, aa.end))
    plain = animate_detailed(line, Options(rig=rig, life=0)).animation
    set_ = animate_detailed(line, Options(rig=rig, life=0, closures=closures)).animation
    assert gap_in(plain, m.start, m.end).min() < 0.1
    assert gap_in(set_, m.start, m.end).max() > 2
    assert gap_in(plain, aa.start, aa.end).max() > 2
    assert gap_in(set_, aa.start, aa.end).max() < 0
    far = set_.times > aa.end + 0.2
    assert np.array_equal(set_.values[far], plain.values[far])


def test_drawn_mouths_say_that_they_have_no_closures(line):
    notes = animate_detailed(line, Options(rig="rhubarb", closures=(Closure("hold", 0.1, 0.2),))).animation
    assert any("closures are held" in note for note in notes.provenance["notes"])


def test_corrections_are_files_of_edits_for_animate(line, phones, tmp_path):
    number = place(phones, "AA")
    spoken = list(phones)
    spoken[number] = Interval("UW", phones[number].start, phones[number].end)
    curve = Edit("browInnerUp", "offset", 1.0, 2.0, (0.1, 0.1), (1.0, 1.5, 2.0), (0.0, 0.5, 0.0))
    write_corrections(
        Corrections(
            PhoneChanges(phones, tuple(spoken)), {"jaw": 0.5}, "", Edits("arkit", 1e-3, phones, (curve,))
        ),
        tmp_path / "line.corrections.json",
    )
    arguments = ["animate", str(line), "-o", str(tmp_path / "line.npz"), "--life", "0", "-q"]
    assert run([*arguments, "--edits", str(tmp_path / "line.corrections.json")]) == 0
    made, plain = load(tmp_path / "line.npz"), animate_detailed(line, Options(life=0)).animation
    assert [p.label for p in made.phones] == [p.label for p in spoken]
    middle = (phones[number].start + phones[number].end) / 2
    frame = round(middle * 60)
    assert made.channel("mouthPucker")[frame] > plain.channel("mouthPucker")[frame] + 0.1
    assert made.channel("browInnerUp")[90] == pytest.approx(plain.channel("browInnerUp")[90] + 0.5, abs=2e-3)
    assert made.provenance["options"]["jaw"] == 0.5
    assert len(made.provenance["edits_sha256"]) == 1


def test_a_line_has_one_file_of_corrections(line, tmp_path, capsys):
    paths = [tmp_path / "a.json", tmp_path / "b.json"]
    for path in paths:
        write_corrections(Corrections(), path)
    given = [argument for path in paths for argument in ("--edits", str(path))]
    assert run(["animate", str(line), "-o", str(tmp_path / "line.npz"), *given]) == 2
    assert "b.json: a line has one file of corrections" in capsys.readouterr().err
    assert not (tmp_path / "line.npz").exists()


def test_no_files_change_nothing(line):
    plain = animate_detailed(line).animation
    assert np.array_equal(animate_corrected(line).animation.values, plain.values)


@pytest.mark.parametrize("rig", ["oculus15", "vrm"])
def test_visemes_add_up_to_one_at_most_after_edits_of_another_rig(line, rig):
    opened = Edit("jawOpen", "offset", 0.0, 3.0, (0.1, 0.1), (0.0, 1.5, 3.0), (0.6, 0.6, 0.6))
    rounded = Edit("mouthPucker", "offset", 0.0, 3.0, (0.1, 0.1), (0.0, 1.5, 3.0), (0.9, 0.9, 0.9))
    animation = animate_detailed(line, Options(rig=rig)).animation
    edited = apply_line_edits(animation, Edits("arkit", 0.01, (), (opened, rounded)), Options(rig=rig))
    shapes = [at for at, name in enumerate(edited.channels) if name in load_rig(rig).controls]
    assert np.abs(edited.values - animation.values).max() > 0.1
    assert edited.values[:, shapes].sum(axis=1).max() <= 1 + 1e-5
    own = Edit(edited.channels[shapes[1]], "offset", 0.0, 3.0, (0.1, 0.1), (0.0, 3.0), (1.0, 1.0))
    kept = apply_line_edits(animation, Edits(rig, 0.01, (), (own,)), Options(rig=rig))
    assert kept.values[:, shapes].sum(axis=1).max() > 1.1
