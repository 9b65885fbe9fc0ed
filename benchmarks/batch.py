"""What `phonanim batch` costs on many lines, and what 30 kills do to it.

    python benchmarks/batch.py FOLDER_OF_TEXTGRIDS [KILLS]
    python benchmarks/batch.py FOLDER_OF_TEXTGRIDS --short COUNT
    python benchmarks/batch.py FOLDER_OF_TEXTGRIDS --lengths
    python benchmarks/batch.py FOLDER_OF_TEXTGRIDS --again COUNT

Prints seconds, lines and frames per second, the processor time of each tenth of the lines (which other work
on the machine hardly changes), and the most memory that all processes together held (shared pages count
once). Then runs the first 300 lines undisturbed, and again
with a SIGKILL to the whole process group at random moments, and compares every byte. Then the processor time
of single lines of 2 seconds to 10 minutes, joined from the same files, and of the same run once more.
With --short, only a run of so many lines of 2 s, which are the beginnings of the files, and the same run and
an audit once more, with the most memory of the first process. With --lengths, only the single lines.
With --again, only the same run and an audit once more, of so many lines of 2 s; the outputs are those of the
first line, so that nothing else has to be made.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path, PurePosixPath

from phonanim.core.threads import use_one_thread

use_one_thread()  # before NumPy is imported, as in a worker

from phonanim.dubbing.job import Job  # noqa: E402
from phonanim.dubbing.ledger import write_ledger  # noqa: E402
from phonanim.dubbing.line import Line  # noqa: E402
from phonanim.dubbing.lines import read_lines  # noqa: E402
from phonanim.dubbing.make import make_line  # noqa: E402
from phonanim.dubbing.outcome import Outcome  # noqa: E402
from phonanim.dubbing.provenance import origin_of  # noqa: E402
from phonanim.dubbing.row import Common  # noqa: E402
from phonanim.dubbing.stamps import OUTPUTS, stamp_inputs, stamp_outputs  # noqa: E402
from phonanim.inputs.alignment import read_alignment  # noqa: E402
from phonanim.options import DEFAULTS  # noqa: E402
from phonanim.speech.alignment import Interval  # noqa: E402
from phonanim.speech.textgrid import write_textgrid  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
FEW = 300
LENGTHS = (2, 6, 60, 600)  # seconds
SHORT = 2.0  # seconds
SETTLE = 2.5  # seconds until the ledger may trust the time of a file


def start(source: Path, out: Path) -> subprocess.Popen[str]:
    command = [sys.executable, str(ROOT / "cli.py"), "batch", str(source), "-o", str(out), "--json"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)


def memory(session: int) -> float:
    """Megabytes that the processes of a session hold."""
    total = 0
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if os.getsid(int(folder.name)) == session:
                rows = (folder / "smaps_rollup").read_text().splitlines()
                total += next(int(row.split()[1]) for row in rows if row.startswith("Pss:"))
        except (OSError, StopIteration):
            continue
    return total / 1024


def processor_time(session: int) -> float:
    """Seconds of processor time that the processes of a session have taken."""
    ticks = 0
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if os.getsid(int(folder.name)) == session:
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
                ticks += sum(map(int, fields[11:15]))  # its own, and that of its children that have ended
        except OSError:
            continue
    return ticks / os.sysconf("SC_CLK_TCK")


def watch(process: subprocess.Popen[str], peak: list[float]) -> None:
    while process.poll() is None:
        peak[0] = max(peak[0], memory(process.pid))
        time.sleep(0.2)


def timed(source: Path, out: Path) -> None:
    """Run all lines and print what it cost."""
    peak = [0.0]
    began = time.perf_counter()
    process = start(source, out)
    watcher = threading.Thread(target=watch, args=(process, peak))
    watcher.start()
    laps, totals = [], {}
    assert process.stdout
    for line in process.stdout:
        totals = json.loads(line)
        if totals["event"] == "line" and totals["done"] % (totals["lines"] // 10) == 1:
            laps.append(processor_time(process.pid))
        if totals["event"] == "line" and totals["done"] == totals["lines"]:
            laps.append(processor_time(process.pid))
    watcher.join()
    wall = time.perf_counter() - began
    lines, frames, hours = totals["lines"], totals["frames"], totals["seconds"] / 3600
    print(f"{lines} lines, {hours:.2f} h of speech: {wall:.1f} s, {peak[0]:.0f} MB at most")
    print(f"{lines / wall:.0f} lines/s, {frames / wall:.0f} frames/s, {totals['failed']} failed")
    tenths = [after - before for before, after in pairwise(laps)]
    print("processor seconds of each tenth of the lines:", " ".join(f"{lap:.1f}" for lap in tenths))
    print(f"{laps[-1]:.1f} processor seconds in all, {frames / laps[-1]:.0f} frames in each")


def contents(folder: Path) -> dict[str, object]:
    """The bytes of every file, and the ledger without sizes and times of files."""
    found: dict[str, object] = {
        str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }
    entries = map(json.loads, (folder / "ledger.jsonl").read_text("utf-8").splitlines())
    return found | {"ledger.jsonl": [{**entry, "stamps": None} for entry in entries]}


def again(source: Path, out: Path) -> None:
    """Processor time of the same command and of an audit, on unchanged lines."""
    commands = {
        "resume": ["batch", str(source), "-o", str(out)],
        "audit": ["audit", str(source), "--outputs", str(out)],
    }
    for name, words in commands.items():
        for more in ([], ["--verify"]):
            process = subprocess.Popen(
                [sys.executable, str(ROOT / "cli.py"), *words, *more],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            _, _, usage = os.wait4(process.pid, 0)
            cost, peak = usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024
            print(f"{' '.join([name, *more])}: {cost:.1f} s of processor time, {peak:.0f} MB")


def killed(source: Path, folder: Path, kills: int) -> None:
    """Compare an undisturbed run with one that was killed again and again."""
    few = folder / "few"
    few.mkdir()
    for path in sorted(source.rglob("*.TextGrid"))[:FEW]:
        shutil.copy(path, few)
    began = time.perf_counter()
    start(few, folder / "calm").communicate()
    wall = time.perf_counter() - began
    rng = random.Random(0)
    hit = 0
    while hit < kills:
        process = start(few, folder / "out")
        time.sleep(rng.uniform(0.1, 0.7 * wall))
        if process.poll() is None:
            hit += 1
            os.killpg(process.pid, signal.SIGKILL)
        else:  # all lines are done: from here on kills would hit nothing
            shutil.rmtree(folder / "out")
        process.communicate()
    start(few, folder / "out").communicate()
    verdict = "the same bytes" if contents(folder / "out") == contents(folder / "calm") else "OTHER BYTES"
    print(f"{kills} kills of a run of {wall:.1f} s while it ran: {verdict}")


def joined(source: Path, seconds: float) -> list[Interval]:
    """The phones of one file after the other, up to an instant."""
    phones: list[Interval] = []
    start = 0.0
    for path in sorted(source.rglob("*.TextGrid")):
        alignment = read_alignment(path)
        phones += [
            Interval(one.label, round(one.start + start, 6), round(one.end + start, 6))
            for one in alignment.intervals
        ]
        start += alignment.duration
        if start >= seconds:
            break
    return [phone for phone in phones if phone.end <= seconds]


def lengths(source: Path, folder: Path) -> None:
    """Processor time of a line, the best of three or more."""
    for seconds in LENGTHS:
        path = folder / f"{seconds}.TextGrid"
        write_textgrid(path, {"phones": joined(source, seconds)}, seconds)
        line = Line(str(seconds), "", path, None, DEFAULTS, PurePosixPath(str(seconds)))
        laps = []
        for _ in range(max(3, 100 // seconds)):
            began = time.process_time()
            error = make_line(Job(line, folder, ("csv",), None)).outcome.error
            assert not error, error
            laps.append(time.process_time() - began)
        cost = 1000 * min(laps)
        print(f"a line of {seconds} s: {cost:.1f} ms of processor time, {cost / seconds:.1f} ms a second")


def shortened(source: Path, folder: Path, count: int) -> Path:
    """A folder of `count` lines of SHORT seconds: the beginnings of files, again and again."""
    folder.mkdir()
    beginnings = []
    for path in sorted(source.rglob("*.TextGrid"))[:count]:
        phones = [one for one in read_alignment(path).intervals if one.end <= SHORT]
        write_textgrid(folder / f"{len(beginnings):05}.TextGrid", {"phones": phones}, SHORT)
        beginnings.append((folder / f"{len(beginnings):05}.TextGrid").read_bytes())
    for number in range(len(beginnings), count):
        (folder / f"{number:05}.TextGrid").write_bytes(beginnings[number % len(beginnings)])
    return folder


def finished(lines: Path, out: Path) -> None:
    """The outputs and the ledger of a run of copies of one line, of which one is made."""
    out.mkdir()
    outcomes: list[Outcome] = []
    for line in read_lines(str(lines), Common()).lines:
        name = f"{line.output}.csv"
        if not outcomes:
            first = make_line(Job(line, out, ("csv",), None)).outcome
            assert not first.error, first.error
        else:
            os.link(out / next(iter(first.outputs)), out / name)
        stamps = {**stamp_inputs(line), OUTPUTS: stamp_outputs([name], out)}
        hashes = dict(zip([name], first.outputs.values(), strict=True))
        origin = origin_of(line, ("csv",))
        outcomes.append(
            replace(first, id=line.id, place=line.place, origin=origin, outputs=hashes, stamps=stamps)
        )
    write_ledger(out, outcomes)


def once_more(source: Path, count: int) -> None:
    """The same run and an audit once more, of many short lines."""
    with tempfile.TemporaryDirectory() as name:
        lines = shortened(source, Path(name) / "lines", count)
        time.sleep(SETTLE)
        finished(lines, Path(name) / "all")
        again(lines, Path(name) / "all")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("source", type=Path, metavar="FOLDER_OF_TEXTGRIDS")
    options.add_argument("kills", type=int, nargs="?", default=30, metavar="KILLS")
    options.add_argument("--short", type=int, metavar="COUNT")
    options.add_argument("--lengths", action="store_true")
    options.add_argument("--again", type=int, metavar="COUNT")
    chosen = options.parse_args()
    if chosen.lengths:
        with tempfile.TemporaryDirectory() as place:
            lengths(chosen.source, Path(place))
    elif chosen.again:
        once_more(chosen.source, chosen.again)
    elif chosen.short:
        short_lines(chosen.source, chosen.short)
    else:
        everything(chosen.source, chosen.kills)


def everything(source: Path, kills: int) -> None:
    """All lines, the same run once more, kills, and single lines."""
    with tempfile.TemporaryDirectory() as name:
        timed(source, Path(name) / "all")
        again(source, Path(name) / "all")
        killed(source, Path(name), kills)
        lengths(source, Path(name))


def short_lines(source: Path, count: int) -> None:
    """A run of many short lines, and the same once more."""
    with tempfile.TemporaryDirectory() as name:
        lines = shortened(source, Path(name) / "lines", count)
        timed(lines, Path(name) / "all")
        again(lines, Path(name) / "all")


if __name__ == "__main__":
    main()
