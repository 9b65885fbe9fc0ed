import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only

from phonanim.errors import OptionError, OutputError
from phonanim.exporters import load, save
from phonanim.exporters._livelink import columns


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.reader(file))


def test_columns_go_by_name(tmp_path):
    save(only(line(), jawRight=0.25, jawLeft=0.5, eyeBlinkLeft=1.0), tmp_path / "a.csv")
    head, first, *rest = rows_of(tmp_path / "a.csv")
    assert head[:3] == ["Timecode", "BlendShapeCount", "EyeBlinkLeft"]
    assert head.index("JawRight") + 1 == head.index("JawLeft")
    cells = dict(zip(head, first, strict=True))
    assert (cells["JawRight"], cells["JawLeft"]) == ("0.2500000000", "0.5000000000")
    assert (cells["Timecode"], cells["BlendShapeCount"]) == ("00:00:00:00.000", "61")
    assert cells["RightEyeRoll"] == "0.0000000000"
    assert len(rest) == 60
    assert all(len(row) == 63 for row in rest)


def test_timecodes_count_sixty_frames_per_second(tmp_path):
    save(line(frames=4, fps=25), tmp_path / "a.csv")
    codes = [row[0] for row in rows_of(tmp_path / "a.csv")[1:]]
    assert codes == ["00:00:00:00.000", "00:00:00:02.400", "00:00:00:04.800", "00:00:00:07.200"]


def test_a_timecode_to_start_from(tmp_path):
    animation = line(frames=3, fps=60000 / 1001)
    save(animation, tmp_path / "a.csv", timecode="00:00:59;59")
    codes = [row[0] for row in rows_of(tmp_path / "a.csv")[1:]]
    assert codes == ["00:00:59;59.000", "00:01:00;04.000", "00:01:00;05.000"]
    again = load(tmp_path / "a.csv")
    assert again.fps == pytest.approx(60000 / 1001)
    save(again, tmp_path / "b.csv")
    assert (tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()
    with pytest.raises(
        OptionError, match=r"'1h' is not a timecode at 60 frames per second; write 01:00:00:02"
    ):
        save(animation, tmp_path / "c.csv", timecode="1h")


def test_a_rig_without_arkit_controls(tmp_path):
    animation = replace(line(), channels=tuple(f"x{i}" for i in range(52)), rig="azure22")
    with pytest.raises(
        OutputError, match=r"a\.csv: the rig azure22 has no ARKit control; choose --rig arkit"
    ):
        save(animation, tmp_path / "a.csv")


def test_frames_that_the_app_dropped_are_filled_in(tmp_path):
    path = tmp_path / "a.csv"
    save(line(frames=6, fps=30), path)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:3] + lines[4:]))
    whole, again = line(frames=6, fps=30), load(path)
    assert again.fps == 30
    assert len(again.values) == 6
    middle = (whole.channel("jawOpen")[1] + whole.channel("jawOpen")[3]) / 2
    assert again.channel("jawOpen")[2] == pytest.approx(middle, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines[:2], r"a\.csv: has fewer than two frames; record it again"),
        (
            lambda lines: ["Time,JawOpen"],
            r"is not a Live Link Face recording; its header must begin with Timecode,",
        ),
        (
            lambda lines: [*lines[:2], "x" + lines[2]],
            r"a\.csv, row 3: 'x00:.*' is not a timecode at 60 frames per second",
        ),
        (lambda lines: [*lines[:2], lines[2] + "x"], r"a\.csv, row 3: could not convert string to float"),
        (
            lambda lines: [*lines[:2], lines[2] + ",1"],
            r"a\.csv, row 3: needs 61 finite numbers after the timecode",
        ),
        (lambda lines: [*lines[:2], lines[2][:-12] + "nan"], r"a\.csv, row 3: needs 61 finite numbers"),
        (
            lambda lines: [*lines[:3], lines[1]],
            r"a\.csv, row 4: its timecode does not increase; remove the row",
        ),
        (lambda lines: ["\udcff"], r"a\.csv: cannot be read: 'utf-8' codec"),
    ],
)
def test_recordings_that_cannot_be_read(tmp_path, change, message):
    path = tmp_path / "a.csv"
    save(line(), path)
    lines = change(path.read_text().splitlines())
    path.write_bytes("\n".join(lines).encode("utf-8", "surrogateescape"))
    with pytest.raises(OutputError, match=message):
        load(path)


def test_our_columns_are_those_of_the_app(shared_data):
    header = json.loads((shared_data / "formats" / "livelink_header.json").read_text())["livelink_csv_header"]
    assert [name[0].lower() + name[1:] for name in header[2:]] == list(columns())


def test_a_real_capture_round_trips(shared_data, tmp_path):
    source = shared_data / "formats" / "livelink_real_capture.csv"
    capture = load(source)
    assert capture.fps == 30
    assert len(capture.values) == 1500  # 1499 rows, and one that the app dropped
    save(capture, tmp_path / "a.csv")
    before, after = rows_of(source), rows_of(tmp_path / "a.csv")
    assert after[0] == before[0]
    # Turns of head and eyes are read into degrees and written in radians; all else is the same to the digit.
    turned = [place for place, name in enumerate(before[0]) if name.endswith(("Yaw", "Pitch", "Roll"))]

    def without_turns(row):
        return tuple(cell for place, cell in enumerate(row) if place > 0 and place not in turned)

    written = {without_turns(row): row for row in after}
    for row in before[1:]:
        again = written[without_turns(row)]
        for place in turned:
            assert float(again[place]) == pytest.approx(float(row[place]), abs=1e-7)
    np.testing.assert_allclose(load(tmp_path / "a.csv").values, capture.values, atol=1e-9)
