"""A line corrected in Blender, Maya and a review keeps all three when it is recorded anew, 15 % longer."""

import json
import re
import shutil

import numpy as np
import pytest

from phonanim.__main__ import run
from phonanim.commands.review import lines_of_run
from phonanim.dubbing.review import open_review
from phonanim.dubbing.review_line import Desk, act, line_page
from phonanim.exporters import load, save
from phonanim.speech.alignment import Interval
from phonanim.speech.textgrid import write_textgrid

LONGER = 1.15
BATCH = [
    "batch",
    "lines",
    "-o",
    "out",
    "--format",
    "npz",
    "--format",
    "glb",
    "--life",
    "0",
    "--workers",
    "1",
    "-q",
]


@pytest.fixture
def folder(root, tmp_path, monkeypatch):
    (tmp_path / "lines").mkdir()
    (tmp_path / "edits").mkdir()
    shutil.copy(root / "examples/line.TextGrid", tmp_path / "lines")
    monkeypatch.chdir(tmp_path)
    assert run(BATCH) == 0
    return tmp_path


def correct_in_blender(folder):
    """The GLB with another jaw, as Blender exports it (docs/engines/blender.md)."""
    take = load(folder / "out/line.glb")
    values = take.values.copy()
    values[115:125, take.channels.index("jawOpen")] += 0.2
    save(take.with_values(values), folder / "blender.glb")
    assert run(["edit", "diff", "out/line.glb", "blender.glb", "-o", "blender.edits.json", "-q"]) == 0


def correct_in_maya(folder):
    """One key of the file of curves dragged up, in the line that has the correction of Blender."""
    given = [
        "lines/line.TextGrid",
        "--edits",
        "blender.edits.json",
        "-o",
        "line.anim",
        "--key-tolerance",
        "0.002",
    ]
    assert run(["animate", *given, "--life", "0", "-q"]) == 0
    text = (folder / "line.anim").read_text()
    start = text.index("anim mouthSmileLeft mouthSmileLeft")
    found = next(
        m for m in re.finditer(r"^    (\d+) (\S+) linear", text[start:], re.MULTILINE) if int(m[1]) > 50
    )
    place = start + found.start(2)
    (folder / "maya.anim").write_text(
        text[:place] + f"{float(found[2]) + 0.3:.7g}" + text[place + len(found[2]) :]
    )
    files = ["line.anim", "maya.anim", "--alignment", "lines/line.TextGrid", "-o", "maya.edits.json"]
    assert run(["edit", "diff", *files, "-q"]) == 0


def correct_in_review(folder):
    """A phone, a closure and a drawn curve, as the page asks for them."""
    review = open_review(folder / "out", lines_of_run(folder / "out"))
    desk = Desk(review, review.decisions())
    data = json.loads(
        line_page(desk, 0, False, "t", "Ann").split('type="application/json">')[1].split("</script>")[0]
    )
    spoken = [list(phone) for phone in data["takes"][0]["phones"]]
    place = next(number for number, phone in enumerate(spoken) if phone[0] == "CH")
    spoken[place][0] = "M"
    asked = {"line": 0, "revision": 0, "who": "Ann", "what": "CH is M", "style": "", "spoken": spoken}
    drawn = {"browInnerUp": [[3.0, 0.6], [3.3, 0.6]]}
    act(desk, "/correct", {**asked, "settings": {"jaw": 0.9}, "drawn": drawn})
    return spoken[place]


def test_all_three_corrections_survive_a_longer_take(folder):
    correct_in_blender(folder)
    correct_in_maya(folder)
    joined = ["blender.edits.json", "maya.edits.json", "-o", "edits/line.edits.json"]
    assert run(["edit", "join", *joined, "-q"]) == 0
    assert run([*BATCH, "--edits", "edits"]) == 0
    phone = correct_in_review(folder)

    take = load(folder / "out/line.npz")
    longer = [Interval(p.label, LONGER * p.start, LONGER * p.end) for p in take.phones]
    write_textgrid(folder / "lines/line.TextGrid", {"phones": longer}, LONGER * float(take.times[-1]))
    assert run([*BATCH, "--edits", "edits"]) == 0
    kept = load(folder / "out/line.npz")

    # without any of them
    settings = ["lines/line.TextGrid", "-o", "plain.npz", "--life", "0", "--jaw", "0.9", "-q"]
    assert run(["animate", *settings]) == 0
    plain = load(folder / "plain.npz")
    jaw = np.flatnonzero(kept.channel("jawOpen") - plain.channel("jawOpen") > 0.15) / 60
    assert (jaw.min(), jaw.max()) == pytest.approx((LONGER * 115 / 60, LONGER * 125 / 60), abs=0.1)
    edits = json.loads((folder / "maya.edits.json").read_text())["edits"][0]
    top = max(edits["keys"], key=lambda key: key[1])[0] * LONGER
    smile = kept.channel("mouthSmileLeft") - plain.channel("mouthSmileLeft")
    assert smile[round(top * 60)] == pytest.approx(0.3, abs=0.08)
    said = [one for one in kept.phones if abs(one.start - LONGER * phone[1]) < 1e-3]
    assert [one.label for one in said] == ["M"]
    middle = round(LONGER * (phone[1] + phone[2]) / 2 * 60)
    assert kept.articulation[middle, 1] < 0 < plain.articulation[middle, 1]
    assert kept.channel("browInnerUp")[round(3.15 * LONGER * 60)] == pytest.approx(0.6, abs=0.02)
    assert kept.provenance["options"]["jaw"] == 0.9
    assert not [note for note in kept.provenance["notes"] if "left out" in note]
