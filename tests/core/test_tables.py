import os

import pytest

from phonanim.core import tables
from phonanim.core.decode import DecodeError


def test_rows_are_read_as_they_stand(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text('\ufeffa,b\n1,"x,\ny"\n\n,\n', encoding="utf-8")
    assert tables.read_rows(path) == [["a", "b"], ["1", "x,\ny"], [], ["", ""]]
    assert tables.read_records(path, ("a",)) == [(2, {"a": "1", "b": "x,\ny"})]


def test_cells_that_are_missing_at_the_end_are_empty(tmp_path):
    (tmp_path / "t.csv").write_text("a,b\n1\n")
    assert tables.read_records(tmp_path / "t.csv") == [(2, {"a": "1", "b": ""})]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"a,b\n1,2,3\n", "row 2 has 3 cells, the header 2"),
        (b"b\n1\n", "it has no column 'a'; its first line needs a,b"),
        (b"", "it has no column 'a'"),
        (b"\xff\n", r"it is not UTF-8 text \(byte 0\)"),
        (b"a,b\n" + b"x" * 200_000 + b"\n", "line 2 is not a row of a table"),
    ],
)
def test_what_is_no_table_is_told(tmp_path, data, message):
    (tmp_path / "t.csv").write_bytes(data)
    with pytest.raises(DecodeError, match=message):
        tables.read_records(tmp_path / "t.csv", ("a", "b"))


def test_size_is_limited(tmp_path, monkeypatch):
    (tmp_path / "t.csv").write_text("a\n" * 20)
    monkeypatch.setattr(tables, "MAX_ROWS", 10)
    with pytest.raises(DecodeError, match="it has more than 10 rows"):
        tables.read_rows(tmp_path / "t.csv")
    with pytest.raises(DecodeError, match="it has more than 0 MB"):
        tables.read_rows(tmp_path / "t.csv", most=10)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "t.csv")
    with pytest.raises(DecodeError, match="it is a pipe or a device"):
        tables.read_rows(tmp_path / "t.csv")


@pytest.mark.parametrize("text", ["nan", "inf", "-1", "2e6", "x", "", "9" * 400, "1_0"])
def test_cells_hold_numbers_within_limits(text):
    if text == "1_0":  # as Python reads it
        assert tables.parse_cell(text, "weight", 0) == 10
        return
    with pytest.raises(DecodeError, match="weight is .*; it is a number from 0 to 1e"):
        tables.parse_cell(text, "weight", 0)
