import json
import pickle
import wave
from dataclasses import replace

import numpy as np
import pytest
from animations import speaking

from phonanim.__main__ import run as run_phonanim
from phonanim.animation.animation import Animation
from phonanim.exporters import save

TEXTGRID = """File type = "ooTextFile"
Object class = "TextGrid"

0
2
<exists>
1
"IntervalTier"
"phones"
0
2
4
0
0.5
"sil"
0.5
1
"AA1"
1
1.2
"P"
1.2
2
"AA1"
"""


@pytest.fixture
def run(capsys):
    """Run the command: exit code, stdout, stderr."""

    def command(*arguments):
        code = run_phonanim(["evaluate", *map(str, arguments)])
        out, err = capsys.readouterr()
        return code, out, err

    return command


@pytest.fixture
def lines(tmp_path):
    """Two lines of a tool and of a capture, an alignment, and vertices."""
    for folder in ("ours", "theirs", "said"):
        (tmp_path / folder).mkdir()
    for name, late in (("a", 0.1), ("b", 0.0)):
        save(speaking(late=late), tmp_path / "ours" / f"{name}.track.json")
        save(speaking(), tmp_path / "theirs" / f"{name}.npz")
        (tmp_path / "said" / f"{name}.TextGrid").write_text(TEXTGRID)
    points = np.random.default_rng(0).normal(size=(60, 5023, 3)).astype(np.float32)
    np.save(tmp_path / "voca.npy", points)
    np.save(tmp_path / "flat.npy", (points + np.array([3.0, 0, 4.0])).reshape(60, -1))
    (tmp_path / "lips.txt").write_text("1, 2, 3")
    return tmp_path


def test_a_line_for_people(run, lines):
    code, out, err = run(
        lines / "ours/a.track.json",
        "--reference",
        lines / "theirs/a.npz",
        "--alignment",
        lines / "said/a.TextGrid",
    )
    assert code == 0
    measures = dict(line.split()[:2] for line in out.splitlines()[1:] if line)
    assert float(measures["aperture_lag_ms"]) == pytest.approx(100, abs=5)
    assert "tmve_lips_mm by class of phones" in out
    assert "bilabials" in out
    assert err == ""


def test_a_line_for_scripts(run, lines):
    code, out, _ = run(
        lines / "ours/a.track.json",
        "--reference",
        lines / "theirs/a.npz",
        "--alignment",
        lines / "said",
        "--json",
    )
    scores = json.loads(out)["files"]["a.track.json"]
    assert code == 0
    assert scores["measures"]["pbm_least_gap_mm"] > 0
    assert [row["name"] for row in scores["phones"]] == ["sil", "p", "aa"]
    assert scores["error_by_phone"] == "tmve_lips_mm"
    assert (scores["frames"], scores["fps"]) == (60, 30)


def test_folders_give_means_and_intervals(run, lines):
    code, out, _ = run(lines / "ours", "--reference", lines / "theirs", "--json")
    facts = json.loads(out)
    assert code == 0
    each = [scores["measures"]["lve_mm"] for scores in facts["files"].values()]
    summary = facts["summary"]["lve_mm"]
    assert summary["mean"] == pytest.approx(np.mean(each))
    assert summary["interval"] == pytest.approx(sorted(each))  # of two files: the worse, the better
    table = run(lines / "ours", "--reference", lines / "theirs")[1]
    assert "a.track.json" in table
    assert "95 % interval" in table


def test_tables_by_phone_are_merged_over_files(run, lines):
    arguments = (lines / "ours", "--reference", lines / "theirs", "--alignment", lines / "said")
    facts = json.loads(run(*arguments, "--json")[1])
    rows = {row["name"]: row for row in facts["phones"]}
    each = [next(r for r in scores["phones"] if r["name"] == "p") for scores in facts["files"].values()]
    assert rows["p"]["frames"] == sum(row["frames"] for row in each)
    assert rows["p"]["mean"] == pytest.approx(np.mean([row["mean"] for row in each]))
    assert "tmve_lips_mm by class of phones" in run(*arguments)[1]


def test_a_real_capture_read_at_half_its_rate(run, lines, shared_data):
    from phonanim.exporters import load

    capture = load(shared_data / "formats" / "livelink_real_capture.csv")
    save(replace(capture, values=capture.values[:300]), lines / "whole.npz")
    save(replace(capture, values=capture.values[:300:2], fps=capture.fps / 2), lines / "half.npz")
    measures = json.loads(run(lines / "half.npz", "--reference", lines / "whole.npz", "--json")[1])
    measures = measures["files"]["half.npz"]["measures"]
    assert 0.9 < measures["aperture_r"] < 1
    assert abs(measures["aperture_lag_ms"]) < 5
    assert 0 < measures["tmve_lips_mm"] < 1
    assert measures["aperture_jerk_ratio"] < 1


def test_the_same_files_give_the_same_bytes(run, lines):
    first, second = (run(lines / "ours", "--reference", lines / "theirs", "--json")[1] for _ in range(2))
    assert first == second


def test_vertices_with_a_mask_of_ones_own(run, lines):
    code, out, err = run(
        lines / "flat.npy", "--reference", lines / "voca.npy", "--mask", f"lips={lines / 'lips.txt'}",
        "--lips", "1,2,3,4", "--unit", "mm", "--fps", "29.97", "--json",
    )  # fmt: skip
    measures = json.loads(out)["files"]["flat.npy"]["measures"]
    assert code == 0, err
    assert measures["lve_mm"] == pytest.approx(5, rel=1e-5)
    assert measures["lve_squared_mm2"] == pytest.approx(25, rel=1e-5)
    assert json.loads(out)["files"]["flat.npy"]["fps"] == pytest.approx(30000 / 1001)


def test_styles_of_a_line_have_a_diversity(run, lines):
    (lines / "styles").mkdir()
    (lines / "captured").mkdir()
    points = np.load(lines / "voca.npy")
    np.save(lines / "captured/line.npy", points)
    np.save(lines / "styles/line_condition_a.npy", points)
    np.save(lines / "styles/line_condition_b.npy", points + np.float32(1))
    code, out, _ = run(lines / "styles", "--reference", lines / "captured", "--unit", "mm", "--json")
    assert code == 0
    assert json.loads(out)["summary"]["diversity_mm"] == {"mean": pytest.approx(3**0.5), "files": 1}


def test_each_subject_has_its_template(run, lines):
    (lines / "faces").mkdir()
    (lines / "rest").mkdir()
    wobble = np.random.default_rng(1).normal(size=(20, 9, 3)).astype(np.float32)
    for subject, size in (("F1", 50), ("F10", 90)):
        rest = size * np.random.default_rng(size).normal(size=(9, 3)).astype(np.float32)
        np.save(lines / "rest" / f"{subject}.npy", rest)
        np.save(lines / "faces" / f"{subject}_e01.npy", rest + wobble)
    (lines / "upper.txt").write_text("0 1 2 3")
    shared = (lines / "faces", "--reference", lines / "faces", "--mask", f"upper={lines / 'upper.txt'}")
    code, out, err = run(*shared, "--template", lines / "rest", "--unit", "mm", "--json")
    assert code == 0, err
    assert json.loads(out)["summary"]["fdd_mm"] == {"mean": 0, "files": 2, "interval": [0, 0]}
    facts = json.loads(run(*shared, "--template", lines / "rest/F1.npy", "--unit", "mm", "--json")[1])
    assert facts["summary"]["fdd_mm"] == {"mean": 0, "files": 1}
    assert "it is another subject's" in facts["files"]["F10_e01.npy"]["notes"][0]
    (lines / "rest/F1.npy").unlink()
    assert "F1_e01.npy: has no subject with a template (F10" in run(*shared, "--template", lines / "rest")[2]


def test_templates_in_a_pickle(run, lines):
    rest = np.zeros((5023, 3))
    (lines / "templates.pkl").write_bytes(pickle.dumps({"voca": rest, "other": rest}))
    code, out, err = run(
        lines / "voca.npy", "--reference", lines / "voca.npy", "--template", lines / "templates.pkl",
        "--mask", f"upper={lines / 'lips.txt'}", "--unit", "mm", "--json",
    )  # fmt: skip
    assert code == 0, err
    assert json.loads(out)["files"]["voca.npy"]["measures"]["fdd_mm"] == 0


def test_options_that_a_way_of_scoring_does_not_read_are_refused(run, lines):
    np.savez(lines / "ema.npz", sensors=np.zeros(3))
    code, _, err = run(
        lines / "ours/a.track.json", "--reference", lines / "ema.npz", "--mask", f"lips={lines / 'lips.txt'}"
    )
    assert code == 2
    assert "--mask cannot be used with sensors of articulography" in err


def test_loudness_of_lines_against_their_lips(run, lines):
    rate = 16000
    times = np.arange(2 * rate) / rate
    voice = sum(np.sin(2 * np.pi * 120 * k * times) / k for k in range(1, 9)) * (np.sin(6 * times) > -0.5)
    (lines / "sound").mkdir()
    for place, name in enumerate("abc"):
        take = speaking()
        save(replace(take, values=take.values * (0.4 + 0.3 * place)), lines / "ours" / f"{name}.track.json")
        save(take, lines / "theirs" / f"{name}.npz")
        loud = (2000 * 2**place * voice).astype("<i2")
        with wave.open(str(lines / "sound" / f"{name}.wav"), "wb") as file:
            file.setparams((1, 2, rate, 0, "NONE", ""))
            file.writeframes(loud.tobytes())
    arguments = (lines / "ours", "--reference", lines / "theirs", "--json", "--sound")
    code, out, err = run(*arguments, lines / "sound")
    assert code == 0, err
    summary = json.loads(out)["summary"]
    assert summary["slcc"]["mean"] > 0.95
    assert "captured_slcc" not in summary  # the same motion thrice has no correlation
    assert run(*arguments, lines / "said")[2].endswith("rename it\n")


def test_what_is_no_number_is_null(run, lines):
    still = Animation(np.zeros((60, 2), np.float32), ("jawOpen", "mouthPucker"), 30, "arkit")
    save(still, lines / "still.npz")
    code, out, _ = run(lines / "still.npz", "--reference", lines / "theirs/a.npz", "--json")
    assert code == 0
    assert json.loads(out, parse_constant=pytest.fail)["files"]["still.npz"]["measures"]["aperture_r"] is None


def test_notes_are_said_and_can_be_kept_quiet(run, lines):
    save(replace(speaking(fps=60)), lines / "fast.npz")
    arguments = (lines / "fast.npz", "--reference", lines / "theirs/a.npz")
    assert "note: predictions at 60 fps, resampled at the reference's 30" in run(*arguments)[2]
    assert run(*arguments, "--quiet")[2] == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("flat.npy", "--reference", "theirs/a.npz"),
            "flat.npy against theirs/a.npz: the predictions have shape",
        ),
        (("flat.npy", "--reference", "theirs"), "give two files or two folders"),
        (("flat.npy", "--reference", "voca.npy", "--lips", "1,b"), "'1,b' is not four vertex numbers"),
        (("flat.npy", "--reference", "voca.npy", "--mask", "lips.txt"), "name its region"),
        (("flat.npy", "--reference", "voca.npy", "--alignment", "said"), "said: has no alignment named flat"),
        (("lips.txt", "--reference", "voca.npy"), "lips.txt: no format has this suffix"),
        (("flat.npy", "--reference", "absent.npy"), "'absent.npy' does not exist"),
    ],
)
def test_bad_input_ends_in_one_line(run, lines, monkeypatch, arguments, message):
    monkeypatch.chdir(lines)
    code, out, err = run(*arguments)
    assert code == 2
    assert out == ""
    assert message in err
    assert "Traceback" not in err


def test_help_shows_an_example(run):
    code, out, _ = run("--help")
    assert code == 0
    assert "phonanim evaluate line.npz --reference capture.csv" in out
