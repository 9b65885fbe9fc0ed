"""Look through `phonanim review` in headless Chromium, with many lines.

    python scripts/check_review.py -o work/check [--lines 10000]

Lists the example line, made once, as often as asked; prints the seconds until the list is drawn and the
memory of the page's script, searches, filters, goes to a line by keys, and plays it. Takes pictures at 1280
and at 390 pixels. Exit code 1, with one line, when a step fails.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

from check_study import Browser

from phonanim.__main__ import run
from phonanim.dubbing.report import worst_first
from phonanim.dubbing.review import Review, open_review
from phonanim.dubbing.review_server import ReviewServer

ROOT = Path(__file__).resolve().parent.parent
PLAYS = "document.getElementById('player').contentDocument.querySelector('canvas') !== null"


def many(review: Review, count: int) -> Review:
    """The review with its line as many lines, every tenth with a flag."""
    one = review.outcomes[0]
    flag = {"check": "speed", "severity": 0.5, "text": "24 phones in the second after 0.40 s"}
    found = [
        replace(one, id=f"act{n % 7}/line{n:05}", facts={**one.facts, "flags": [] if n % 10 else [flag]})
        for n in range(count)
    ]
    return replace(review, outcomes=tuple(worst_first(found)))


def look(browser: Browser, address: str, count: int, folder: Path) -> None:
    """Open the list, search, filter, and play."""
    started = time.monotonic()
    browser.call("Page.navigate", url=address)
    browser.wait(f"document.getElementById('count')?.textContent === '{count} of {count}'")
    seconds = time.monotonic() - started
    browser.call("HeapProfiler.collectGarbage")
    memory = browser.call("Runtime.getHeapUsage")["usedSize"] / 1e6
    print(f"{count} lines listed in {seconds:.2f} s, {memory:.0f} MB of the page's script")
    browser.value("search.value = 'act3 00'; search.dispatchEvent(new Event('input'))")
    browser.wait("Number(count.textContent.split(' ')[0]) < lines.length / 4 && shown.length > 0")
    browser.value("search.value = ''; search.dispatchEvent(new Event('input'))")
    status = "document.getElementById('status')"
    browser.value(f"{status}.value = 'flagged'; {status}.dispatchEvent(new Event('change'))")
    browser.wait(f"shown.length === {-(-count // 10)}")
    browser.value("list.focus()")
    for key, code, number in (
        ("j", "KeyJ", 74),
        ("j", "KeyJ", 74),
        ("k", "KeyK", 75),
        ("Enter", "Enter", 13),
    ):
        for kind in ("keyDown", "keyUp"):
            event = {"key": key, "code": code, "windowsVirtualKeyCode": number}
            browser.call("Input.dispatchKeyEvent", type=kind, **event)
    browser.wait("chosen === 1 && playing === shown[1].number")
    browser.wait(PLAYS)
    time.sleep(3)
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=" ", code="Space", windowsVirtualKeyCode=32)
    browser.wait(
        "document.getElementById('player').contentDocument.getElementById('play').textContent === 'Pause'"
    )
    for width in (1280, 390):
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
        browser.call("Emulation.setDeviceMetricsOverride", **size)
        time.sleep(1)
        browser.picture(folder / f"review{width}.png")
        if browser.value("document.documentElement.scrollWidth") > width:
            raise RuntimeError(f"the page is wider than {width} pixels")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--lines", type=int, default=10000)
    options = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        print("needs chromium or google-chrome", file=sys.stderr)
        return 1
    made = options.output / "run"
    arguments = [str(ROOT / "examples" / "line.TextGrid*"), "-o", str(made), "--format", "npz", "-q"]
    if run(["batch", *arguments, "--workers", "1"]):
        return 1
    review = many(open_review(made), options.lines)
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        ReviewServer(review, "t") as server,
    ):
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = Browser(program, profile, options.output)
        try:
            look(browser, server.address, options.lines, options.output)
        except RuntimeError as error:
            browser.picture(options.output / "failed.png")
            print(error, file=sys.stderr)
            return 1
        finally:
            browser.close()
            server.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
