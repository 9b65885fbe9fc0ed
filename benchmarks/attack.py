"""Attack the commands with hostile files, and count what holds.

    python benchmarks/attack.py                 every attack, with 400 random files of each kind
    python benchmarks/attack.py --small         12 of each kind and none that grow, for continuous integration

Each attack runs a command in a process of its own, on files that it prepares. It ends as `held` (the command
does its work, or leaves out what it cannot use), as `clear error` (one line, exit code 2), or as a `fault`:
a traceback, a signal, more than 20 s of processor time, two minutes by the clock, more than 1 GB, a file
that is changed or a connection that is made without being asked for. At the end a live stream to clients
that never read is interrupted.
The table goes to stdout; every fault is told with the seed that makes it again. Needs a POSIX system.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import signal
import socket
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Thread

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.crafted import CRAFTED
from benchmarks.crafted_archives import ARCHIVES
from benchmarks.crafted_patterns import PATTERNS
from benchmarks.crafted_sizes import GROWING
from benchmarks.hostile import KINDS, Attack, Samples, make_samples
from benchmarks.hostile_documents import DOCUMENTS
from benchmarks.hostile_folders import FOLDERS
from benchmarks.hostile_inputs import INPUTS
from benchmarks.stuck import Ending, interrupt_stream

SECONDS, MEGABYTES = 20.0, 1000  # of processor time, so that other work on the machine changes nothing
PATIENCE = 120.0  # seconds by the clock after which a command counts as waiting without end
ADDRESS_SPACE = 8 << 30  # bytes that a process may ask for: enough to see what it really takes
VICTIM = "do not change"


@dataclass(frozen=True)
class End:
    """How an attack ended: the kind of end, and what is to be told of a fault."""

    kind: str
    why: str = ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the attacks, print the table, and return 1 where there is a fault."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument(
        "--small", action="store_true", help="12 random files of each kind instead of 400, none that grow"
    )
    parser.add_argument("--count", type=int, help="random files of each kind")
    parser.add_argument("--seed", type=int, default=0, help="of the first random file")
    parser.add_argument("--only", help="one kind of file")
    options = parser.parse_args(arguments)
    count = options.count or (12 if options.small else 400)
    with tempfile.TemporaryDirectory(prefix="attack-") as folder, counted_connections() as connections:
        samples = make_samples(Path(folder) / "samples", connections.port)
        table: dict[str, Counter[str]] = {}
        faults: list[str] = []
        for kind, name, attack in list_attacks(samples, options.seed, count, options.only, options.small):
            end = carry_out(attack, Path(folder) / "work", connections)
            table.setdefault(kind, Counter())[end.kind] += 1
            if end.kind == "fault":
                faults.append(f"{kind} {name}: {end.why}")
    if options.only in (None, "stream"):
        size, tries = ((50, 20, 2.0), 1) if options.small else ((200, 50, 6.0), 3)
        endings = [interrupt_stream(*size) for _ in range(tries)]  # other work on the machine only adds time
        ending = min(endings, key=lambda one: one.seconds)
        end = judge_ending(ending, 5.0 if options.small else 1.0)
        table["stream"] = Counter([end.kind])
        faults += [f"stream: {end.why}"] if end.why else []
        print(f"a stream to clients that never read ends {ending.seconds:.2f} s after an interrupt")
    print_table(table)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


def judge_ending(ending: Ending, seconds: float) -> End:
    """Whether a stream ended as it should after an interrupt, within some seconds."""
    if ending.code != 130 or "Traceback" in ending.told:
        return End("fault", f"code {ending.code}: {ending.told[-300:]!r}")
    if ending.seconds > seconds or ending.megabytes > MEGABYTES:
        return End("fault", f"took {ending.seconds:.1f} s to end, and {ending.megabytes:.0f} MB")
    return End("held")


def list_attacks(
    samples: Samples, seed: int, count: int, only: str | None, small: bool
) -> list[tuple[str, str, Callable[[Path], Attack]]]:
    """Every attack: its kind, its name, and what prepares it in a folder."""
    found: list[tuple[str, str, Callable[[Path], Attack]]] = []
    for kind, make in (KINDS | DOCUMENTS | INPUTS | FOLDERS).items():
        for number in range(seed, seed + count):

            def prepare(folder: Path, make: object = make, number: int = number) -> Attack:
                return make(samples, folder, random.Random(number))  # type: ignore[operator]

            found.append((kind, f"seed {number}", prepare))
    for name, craft in (CRAFTED | ARCHIVES if small else CRAFTED | ARCHIVES | GROWING | PATTERNS).items():

        def prepare_crafted(folder: Path, craft: object = craft) -> Attack:
            return craft(samples, folder)  # type: ignore[operator]

        found.append((name.partition(":")[0], name, prepare_crafted))
    return [attack for attack in found if only in (None, attack[0])]


def carry_out(prepare: Callable[[Path], Attack], folder: Path, connections: Connections) -> End:
    """Prepare an attack in an empty folder, run its command, and look at what became of it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "victim").write_text(VICTIM)
    before = connections.count
    arguments = prepare(folder)
    code, seconds, megabytes, told = run_command(arguments, folder)
    if connections.count > before:
        return End("fault", "a connection was made")
    if (folder / "victim").read_bytes() != VICTIM.encode():
        return End("fault", "a file was changed that is none of the command's")
    if seconds > PATIENCE or code == -signal.SIGKILL:
        return End("fault", f"did not end within {PATIENCE:.0f} s")
    if seconds > SECONDS or code == -signal.SIGXCPU:
        return End("fault", f"took more than {SECONDS:.0f} s")
    if megabytes > MEGABYTES:
        return End("fault", f"took {megabytes:.0f} MB")
    if code < 0:
        return End("fault", f"ended by {signal.Signals(-code).name}")
    if "Traceback" in told or "report it" in told:
        return End("fault", told.strip().splitlines()[-1][:200])
    if code in (0, 1):
        return End("held")
    lines = told.strip().splitlines()
    return (
        End("clear error") if code == 2 and len(lines) == 1 else End("fault", f"code {code}: {told[:300]!r}")
    )


def _resident_megabytes() -> float:
    """What this process holds now; 0 where the system does not say."""
    path = Path("/proc/self/statm")
    return int(path.read_text().split()[1]) * resource.getpagesize() / 2**20 if path.exists() else 0.0


def run_command(arguments: Sequence[str], folder: Path) -> tuple[int, float, float, str]:
    """Run a command of phonanim in a fork of this process: exit code, processor seconds, megabytes, stderr.

    The memory is what the fork takes beyond that of this process. A command that waits too long is killed,
    and its seconds are those by the clock.
    """
    began, inherited = time.monotonic(), _resident_megabytes()
    with tempfile.TemporaryFile() as told:
        child = os.fork()
        if child == 0:
            _be_the_command(arguments, folder, told.fileno())
        while True:
            done, status, usage = os.wait4(child, os.WNOHANG)
            if done or time.monotonic() - began > PATIENCE:
                break
            time.sleep(0.005)
        if not done:
            os.kill(child, signal.SIGKILL)
            _, status, usage = os.wait4(child, 0)
        seconds = usage.ru_utime + usage.ru_stime if done else time.monotonic() - began
        told.seek(0)
        text = told.read().decode("utf-8", "replace")
    return os.waitstatus_to_exitcode(status), seconds, usage.ru_maxrss / 1024 - inherited, text


def _be_the_command(arguments: Sequence[str], folder: Path, told: int) -> None:
    """What the fork does; it never returns."""
    code = 70
    try:
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
        resource.setrlimit(resource.RLIMIT_CPU, (int(SECONDS) + 2, int(SECONDS) + 10))
        os.dup2(os.open(os.devnull, os.O_RDWR), 1)
        os.dup2(told, 2)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
        os.chdir(folder)
        os.environ["PHONANIM_PATH"] = str(folder / "own")
        from phonanim.__main__ import main as command

        sys.argv = ["phonanim", *arguments]
        command()
    except SystemExit as end:
        code = int(end.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


class Connections:
    """A server that counts who connects to it, and answers nobody."""

    def __init__(self) -> None:
        self.count = 0
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.port = int(self.socket.getsockname()[1])
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while True:
            try:
                self.socket.accept()[0].close()
            except OSError:
                return
            self.count += 1

    def __enter__(self) -> Connections:
        return self

    def __exit__(self, *given: object) -> None:
        self.socket.close()


counted_connections = Connections


def print_table(table: dict[str, Counter[str]]) -> None:
    """The ends of each kind of attack."""
    ends = ("held", "clear error", "fault")
    print(f"{'kind':<12}" + "".join(f"{end:>14}" for end in ends))
    for kind, counts in table.items():
        print(f"{kind:<12}" + "".join(f"{counts[end]:>14}" for end in ends))
    total = sum(table.values(), Counter[str]())
    print(f"{'all':<12}" + "".join(f"{total[end]:>14}" for end in ends))
    print(f"{total['fault']} faults in {total.total()} attacks")


if __name__ == "__main__":
    sys.exit(main())
