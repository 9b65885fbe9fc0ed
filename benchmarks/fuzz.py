"""Damaged alignment files: does each end in a track or in one printable line, how fast, in what memory?

    python benchmarks/fuzz.py [--count 20000] [--seconds 600] [--seed 0]

The files are mutants of tests/support/timing_samples.py, which has a sample of every reader; one in ten is
made by hypothesis from nothing. The same seed gives the same files. Prints how they ended, the slowest, the
most memory, and every fault with its file, kept in a temporary folder. Exit code 1 when there is a fault: a
traceback, more than a line, a track whose times do not rise, more than 10 s, or more than 1 GB in all.
"""

from __future__ import annotations

import argparse
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from timing_samples import EVERY  # noqa: E402 - the folder of tests is no package

from phonanim.errors import PhonanimError  # noqa: E402
from phonanim.inputs.alignment import read_alignment  # noqa: E402
from phonanim.speech.language import to_phones  # noqa: E402

HANG = 10  # seconds
MEMORY = 1000  # megabytes
INVENTED = 10  # of so many files one comes from hypothesis
LEXICON = "beam B IY1 M\n"
SEEDS = [sample.data for group in EVERY.values() for sample in group]

# What breaks parsers: numbers that are none, sizes that lie, quotes, line ends, encodings.
ODD = [
    *(b"nan", b"inf", b"-0", b"-1", b"1e308", b"1e-320", b"0x10", b"9" * 25, b"2147483648", b"\xd9\xa3"),
    *(b'"', b'""', b"<exists>", b"size = 999999999", b"{", b"[", b"[[[[", b"}", b"]", b"null", b"true"),
    *(b"<", b"</", b"&lt;", b"&x;", b"<!ENTITY", b"\\u0000", b"\\ud800", b"\\"),
    *(b"\0", b"\n", b"\r", b"\t", b"\x0b", b"\x1b[31m", b"\x80", b"\xff\xff\xff\xff", b"\xc2\x85"),
    *("\u2028".encode(), "\u202e".encode(), b"\xef\xbb\xbf", b"\xff\xfe", b"\xed\xa0\x80"),
]


# Small files that grow when they are read: entities of XML, nesting, long numbers, anchors of YAML.
LAUGHS = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10 if n else "ha" * 10}">' for n in range(10))
ROOTS = (b"ANNOTATION_DOCUMENT", b"rhubarbResult", b"Document", b"timing", b"tt")
BOMBS = [
    *(
        b"<?xml version='1.0'?><!DOCTYPE x ["
        + LAUGHS.encode()
        + b"]><"
        + root
        + b"><Tier><EffectLayer>&e9;</"
        b"EffectLayer></Tier></" + root + b">"
        for root in ROOTS
    ),
    *(b"<" + root + b"><Tier><EffectLayer>" * 3000 for root in ROOTS),
    *(
        b'{"' + key + b'":' + b"[" * 20_000
        for key in (b"words", b"segments", b"NBest", b"fragments", b"voices")
    ),
    *(
        b'{"' + key + b'":' + b'[{"' + key + b'":' * 400 + b"1" + b"}]" * 400
        for key in (b"words", b"segments", b"fragments", b"children", b"results", b"alternatives")
    ),
    b'{"phonemes": [{"phoneme": "a", "start": ' + b"9" * 4000 + b', "end": 1e999}]}',
    b'{"time": 1, "type": "viseme", "value": "p"}\n' * 30_000,
    b"ustx_version: 1\nvoice_parts: " + b"[" * 20_000,
    b"ustx_version: 1\na: &a [x,x,x,x,x,x,x,x]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a]\nvoice_parts: *b\n",
    b"1\n00:00:00,200 --> 00:00:00,600\n" * 5000,
    b"<00:00.1>" * 20_000 + b"\n00:00.100 --> 00:00.200\n" + b"<00:00.1>" * 20_000,
]


class HangError(Exception):
    """A file that takes too long; no TimeoutError, which readers would take for a fault of the disk."""


@dataclass
class Tally:
    """How the files ended; `faults` pairs what went wrong with the bytes that did it."""

    ends: Counter[str] = field(default_factory=Counter)
    faults: list[tuple[str, bytes]] = field(default_factory=list)
    slowest: float = 0.0
    wall: float = 0.0


def mutants(rng: random.Random) -> Iterator[bytes]:
    """Samples with up to five changes, without end."""
    while True:
        data = rng.choice(SEEDS)
        for _ in range(rng.choice([1, 1, 1, 2, 3, 5])):
            data = rng.choice(CHANGES)(data, rng)
        yield data


def flip(data: bytes, rng: random.Random) -> bytes:
    start, _ = span(data, rng)
    return data[:start] + bytes([rng.randrange(256)]) + data[start + 1 :]


def drop(data: bytes, rng: random.Random) -> bytes:
    start, end = span(data, rng)
    return data[:start] + data[end:]


def repeat(data: bytes, rng: random.Random) -> bytes:
    start, end = span(data, rng)
    return data[:end] + data[start:end] * rng.choice([1, 1, 2, 100]) + data[end:]


def move(data: bytes, rng: random.Random) -> bytes:
    start, end = span(data, rng)
    rest = data[:start] + data[end:]
    place, _ = span(rest, rng)
    return rest[:place] + data[start:end] + rest[place:]


def disturb(data: bytes, rng: random.Random) -> bytes:
    """An odd piece in place of a number, a word, or nothing."""
    start, end = span(data, rng)
    return data[:start] + rng.choice(ODD) + data[rng.choice([start, start + 1, end]) :]


def splice(data: bytes, rng: random.Random) -> bytes:
    """The beginning of one file and the end of another."""
    other = rng.choice(SEEDS)
    return data[: span(data, rng)[0]] + other[span(other, rng)[0] :]


def cut(data: bytes, rng: random.Random) -> bytes:
    return data[: span(data, rng)[0]]


def recode(data: bytes, rng: random.Random) -> bytes:
    text = data.decode("latin-1")
    return text.encode(rng.choice(["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "utf-32"]))


CHANGES: list[Callable[[bytes, random.Random], bytes]] = [
    *(flip, drop, repeat, move, disturb, disturb, disturb, splice, cut, recode)
]


def span(data: bytes, rng: random.Random) -> tuple[int, int]:
    """Somewhere in the bytes, mostly short."""
    start = rng.randint(0, len(data))
    return start, min(len(data), start + rng.choice([1, 1, 2, 5, 20, 200]))


def inventions() -> st.SearchStrategy[bytes]:
    """Bytes, rows of times and labels, and nested JSON that no sample suggested."""
    number = st.floats() | st.integers() | st.sampled_from([0.0, 0.1, 0.2, 0.5, 1.0])
    label = st.text(max_size=6) | st.sampled_from(["", "b", "IY1", "m", "sil", "iː"])
    row = st.tuples(number, number, label).map(lambda cells: " ".join(map(str, cells)))
    rows = st.lists(row, min_size=1, max_size=12).map("\n".join)
    keys = ("words", "phones", "tiers", "entries", "start", "end", "word", "levels", "mouthCues", "result")
    tree = st.recursive(
        st.none() | st.booleans() | number | label,
        lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(keys), inner, max_size=4),
        max_leaves=12,
    )
    marks = st.lists(st.sampled_from(ODD), max_size=12).map(b"".join)
    texts = rows | tree.map(lambda value: repr(value).replace("'", '"').replace("None", "null"))
    return st.binary(max_size=200) | marks | texts.map(lambda text: text.encode("utf-8", "surrogatepass"))


def invent(count: int, seed_: int, use: Callable[[bytes], None]) -> None:
    """Hand `count` files that hypothesis makes to `use`."""
    if count == 0:
        return

    @seed(seed_)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(inventions())
    def each(data: bytes) -> None:
        use(data)

    each()


def fault_of(path: Path, lexicon: Path) -> tuple[str, str]:
    """How a file ends, "track" or "line", and what is wrong about that: "" when nothing is."""
    try:
        track, _ = to_phones(read_alignment(path, lexicon=lexicon), unknown="nearest")
    except PhonanimError as error:
        message = str(error)
        fine = message.isprintable() and str(path.parent) in message
        return "line", "" if fine else f"is not one line that names the file: {message!r}"
    except Exception:
        return "traceback", traceback.format_exc()
    rising = bool((track.bounds[1:] > track.bounds[:-1]).all())
    return "track", "" if rising else "times do not rise"


def hung(number: int, frame: FrameType | None) -> None:
    raise HangError(f"took more than {HANG} s")


def attempt(data: bytes, folder: Path, tally: Tally) -> None:
    """Read one file and count how it ended."""
    path = folder / "mutant"
    path.write_bytes(data)
    started = time.perf_counter()
    signal.alarm(HANG)
    end, fault = fault_of(path, folder / "words.dict")
    signal.alarm(0)
    tally.slowest = max(tally.slowest, time.perf_counter() - started)
    tally.ends[end] += 1
    if fault:
        tally.faults.append((fault, data))


def fuzz(count: int, seconds: float, seed_: int, folder: Path) -> Tally:
    """Read up to `count` damaged files in up to `seconds`, using a folder."""
    (folder / "words.dict").write_text(LEXICON)
    tally = Tally()
    signal.signal(signal.SIGALRM, hung)
    started = time.perf_counter()

    def use(data: bytes) -> None:
        if time.perf_counter() - started < seconds:
            attempt(data, folder, tally)

    for bomb in BOMBS:
        use(bomb)
    # In portions, so that a run that time ends has had some of both.
    source = mutants(random.Random(seed_))
    for portion in range(0, count, 1000):
        size = min(1000, count - portion)
        for _ in range(size - size // INVENTED):
            use(next(source))
        if time.perf_counter() - started < seconds:
            invent(size // INVENTED, seed_ + portion, use)
    tally.wall = time.perf_counter() - started
    return tally


def keep(faults: list[tuple[str, bytes]]) -> None:
    """Print every fault and where its file is."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    for number, (what, data) in enumerate(faults):
        path = folder / f"{number}"
        path.write_bytes(data)
        print(f"{path}: {what}")


def peak() -> float:
    """Most memory that this program held, in MB; what `getrusage` says may be that of who started it."""
    status = Path("/proc/self/status")
    if status.is_file():
        lines = status.read_text(encoding="ascii", errors="replace").splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=0)
    given_ = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        tally = fuzz(given_.count, given_.seconds, given_.seed, Path(name))
    memory = peak()
    files = sum(tally.ends.values())
    ends = ", ".join(f"{count} {end}" for end, count in tally.ends.most_common())
    print(f"{files} files in {tally.wall:.1f} s ({1000 * tally.wall / max(files, 1):.1f} ms each): {ends}")
    print(f"slowest {1000 * tally.slowest:.0f} ms, {memory:.0f} MB at most, {len(tally.faults)} faults")
    if tally.faults:
        keep(tally.faults)
    return int(bool(tally.faults) or memory > MEMORY or files == 0)


if __name__ == "__main__":
    sys.exit(main())
