import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from phonanim.core.files import (
    atomic_path,
    concatenate_pieces,
    content_hash,
    is_leftover,
    make_folder_within,
    read_bounded,
    write_text,
)
from phonanim.errors import OutputError


def test_the_file_appears_whole_and_alone(tmp_path):
    with atomic_path(tmp_path / "a.csv") as partial:
        assert partial.parent == tmp_path
        assert partial.suffix == ".csv"
        partial.write_text("new")
        assert not (tmp_path / "a.csv").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
    assert (tmp_path / "a.csv").read_text() == "new"


def test_a_failure_leaves_what_was_there(tmp_path):
    (tmp_path / "a.csv").write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_path(tmp_path / "a.csv") as partial:
        partial.write_text("half")
        raise ZeroDivisionError
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
    assert (tmp_path / "a.csv").read_text() == "old"


def test_a_full_disk_is_one_line(tmp_path):
    message = r"a\.csv: cannot be written: No space left on device"
    with pytest.raises(OutputError, match=message), atomic_path(tmp_path / "a.csv"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert list(tmp_path.iterdir()) == []


def test_places_that_hold_no_file(tmp_path):
    with pytest.raises(OutputError, match=r"is a folder; name a file in it"):
        write_text(tmp_path, "")
    with pytest.raises(OutputError, match=r"the folder .*missing does not exist; create it first"):
        write_text(tmp_path / "missing" / "a.csv", "")
    (tmp_path / "device.csv").symlink_to("/dev/null")
    with pytest.raises(OutputError, match=r"device.csv: is not a plain file; name another"):
        write_text(tmp_path / "device.csv", "")


def test_a_link_is_replaced_and_not_followed(tmp_path, caplog):
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "link.csv").symlink_to("real.csv")
    (tmp_path / "dangling.csv").symlink_to("nowhere.csv")
    for name in ("link.csv", "dangling.csv"):
        write_text(tmp_path / name, "new")
        assert not (tmp_path / name).is_symlink()
        assert (tmp_path / name).read_text() == "new"
        assert (
            f"{name}: was a link; it is a plain file now, and the file behind it is unchanged" in caplog.text
        )
    assert (tmp_path / "real.csv").read_text() == "old"
    assert not (tmp_path / "nowhere.csv").exists()


@pytest.mark.parametrize("aim", ["../elsewhere", "../missing", "sub"])
def test_no_folder_is_made_through_a_link_that_leads_out(tmp_path, aim):
    for name in ("out", "elsewhere"):
        (tmp_path / name).mkdir()
    (tmp_path / "out/sub").symlink_to(aim)
    for place in ("out/sub", "out/sub/below"):
        with pytest.raises(OutputError, match=r"sub.*: (a link points outside|cannot be created)"):
            make_folder_within(tmp_path / place, tmp_path / "out")
    assert not list((tmp_path / "elsewhere").iterdir())
    assert not (tmp_path / "missing").exists()


def test_folders_within_a_folder_that_is_a_link_itself(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "out").symlink_to("real")
    (tmp_path / "real/sub").symlink_to("other")
    (tmp_path / "real/other").mkdir()
    made = make_folder_within(tmp_path / "out/sub/below", tmp_path / "out")
    assert made.is_dir()
    assert (tmp_path / "real/other/below").is_dir()


def test_the_links_of_the_system_stay(tmp_path):
    with pytest.raises(OutputError, match=r"/dev/stdout: is not a plain file; name another"):
        write_text(Path("/dev/stdout"), "")


def test_names_that_are_not_utf8_are_not_written(tmp_path):
    with pytest.raises(OutputError, match=r"a\.json: would hold a name that is not UTF-8; rename the file"):
        write_text(tmp_path / "a.json", "\udcff")
    assert not list(tmp_path.iterdir())


def test_leftovers_are_our_own_unfinished_files_of_processes_that_ended(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    ours = [f".{ended.pid:06x}0123ab.partial.csv", ".ffffff0123ab.partial"]
    others = [
        ".notes.partial.txt",
        ".0123.partial.csv",
        f".{os.getpid():06x}0123ab.partial.csv",
        "a.partial.csv",
    ]
    for name in ours + others:
        (tmp_path / name).write_text("half")
    (tmp_path / ".ffffff0123ac.partial.csv").symlink_to(ours[0])
    assert sorted(path.name for path in tmp_path.iterdir() if is_leftover(path)) == sorted(ours)


def test_the_hash_of_a_folder_sees_names_and_contents(tmp_path):
    write_text(tmp_path / "a", "1")
    first = content_hash(tmp_path)
    assert content_hash(tmp_path) == first
    (tmp_path / "a").rename(tmp_path / "b")
    second = content_hash(tmp_path)
    write_text(tmp_path / "b", "2")
    assert len({first, second, content_hash(tmp_path)}) == 3
    assert content_hash(tmp_path / "b") == "d4735e3a265e16eee03f59718b9b5d03019c07d8b6c51f90da3a666eec13ab35"


def test_arrays_are_gathered_in_memory_or_in_a_file(monkeypatch):
    pieces = [np.full((count, 2, 3), count, np.float16) for count in (3, 0, 5)]
    assert np.array_equal(concatenate_pieces(iter(pieces)), np.concatenate(pieces))
    monkeypatch.setattr("phonanim.core.files.LARGE", 50)
    found = concatenate_pieces(iter(pieces))
    assert isinstance(found, np.memmap)
    assert np.array_equal(found, np.concatenate(pieces))
    assert found.dtype == np.float16


def test_no_room_for_large_arrays_is_one_line(monkeypatch):
    def full(*given):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("phonanim.core.files.tempfile.SpooledTemporaryFile", full)
    with pytest.raises(
        OutputError, match=r"has no room for 0 MB or more \(No space left .*; set TMPDIR to a larger folder"
    ):
        concatenate_pieces([np.zeros(3)])


def test_reading_is_bounded(tmp_path):
    (tmp_path / "a").write_bytes(b"x" * (1 << 20))
    assert len(read_bounded(tmp_path / "a", 1 << 20)) == 1 << 20
    (tmp_path / "a").write_bytes(b"x" * ((1 << 20) + 1))
    with pytest.raises(ValueError, match="it has more than 1 MB"):
        read_bounded(tmp_path / "a", 1 << 20)
    with pytest.raises(FileNotFoundError):
        read_bounded(tmp_path / "b", 1)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a system with named pipes")
def test_pipes_and_devices_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(ValueError, match="it is a pipe or a device; save its content to a plain file"):
            read_bounded(path, 1)
