"""Look through `phonanim review` in headless Chromium, correct a line, and approve it.

    python scripts/check_review.py -o work/check [--lines 10000]

Lists the example line, made once, as often as asked; prints the seconds until the list is drawn, the memory
of the page's script and of its process, searches, filters, goes to a line by keys, and plays it. Then it
drags the boundary of a phone with the mouse, changes a label, holds a closure, draws over a curve, sets a
style, undoes and approves, and prints how long each took; the next batch must have what was corrected. Takes
pictures at 1280 and at 390 pixels. Exit code 1, with one line, when a step fails.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import threading
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from browser import Browser

from phonanim.__main__ import run
from phonanim.commands.review import lines_of_run
from phonanim.dubbing.report import worst_first
from phonanim.dubbing.review import Review, open_review
from phonanim.dubbing.review_server import ReviewServer
from phonanim.exporters import load

ROOT = Path(__file__).resolve().parent.parent
PAGE = "document.getElementById('player').contentWindow"


def many(review: Review, count: int) -> Review:
    """The review with its line as many lines, every tenth with a flag."""
    one, line = review.outcomes[0], next(iter(review.lines.values()))
    flag = {"check": "speed", "severity": 0.5, "text": "24 phones in the second after 0.40 s"}
    found = [
        replace(one, id=f"act{n % 7}/line{n:05}", facts={**one.facts, "flags": [] if n % 10 else [flag]})
        for n in range(count - 1)
    ]
    listed = tuple(worst_first(found))
    # The second of the list is the line itself, and can be corrected.
    return replace(review, outcomes=(listed[0], one, *listed[1:]), lines={line.id: line})


def look(browser: Browser, address: str, count: int) -> None:
    """Open the list, search, filter, and play."""
    browser.call("Performance.enable")
    started = time.monotonic()
    browser.call("Page.navigate", url=address)
    browser.wait(f"document.getElementById('count')?.textContent === '{count} of {count}'")
    seconds = time.monotonic() - started
    metrics = {one["name"]: one["value"] for one in browser.call("Performance.getMetrics")["metrics"]}
    browser.call("HeapProfiler.collectGarbage")
    memory = browser.call("Runtime.getHeapUsage")["usedSize"] / 1e6
    print(f"{count} lines listed in {seconds:.2f} s, {memory:.0f} MB of the page's script")
    print(f"{metrics['TaskDuration']:.2f} s of them in the page's tasks")
    print(f"{resident_memory(browser.process.pid):.0f} MB in the page's process")
    browser.value("search.value = 'act3 00'; search.dispatchEvent(new Event('input'))")
    browser.wait("Number(count.textContent.split(' ')[0]) < lines.length / 4 || lines.length < 100")
    browser.value("search.value = ''; search.dispatchEvent(new Event('input'))")
    status = "document.getElementById('status')"
    browser.value(f"{status}.value = 'flagged'; {status}.dispatchEvent(new Event('change'))")
    browser.wait(f"shown.length === {-(-(count - 1) // 10)}")
    browser.value(f"{status}.value = ''; {status}.dispatchEvent(new Event('change'))")
    browser.value("list.focus()")
    for key in ("j", "j", "k", "Enter"):
        press(browser, key)
    browser.wait("chosen === 1 && playing === shown[1].number")
    browser.wait(f"{PAGE}?.phonanim?.line !== undefined && {PAGE}.phonanim.stage.heads.length > 0")
    press(browser, " ")
    browser.wait(f"{PAGE}.phonanim.player.time > 0.1")
    browser.value(f"{PAGE}.phonanim.player.pause()")


def press(browser: Browser, key: str) -> None:
    """Press a key."""
    codes = {"Enter": 13, "Escape": 27, " ": 32}
    number = codes.get(key, ord(key.upper()[0]))
    text = {"Enter": "\r", "Escape": ""}.get(key, key)
    event = {"key": key, "windowsVirtualKeyCode": number}
    browser.call("Input.dispatchKeyEvent", type="keyDown", text=text, **event)
    browser.call("Input.dispatchKeyEvent", type="keyUp", **event)


def drag(browser: Browser, points: list[tuple[float, float]]) -> None:
    """Drag the mouse over the page of the line, (x, y) in its timeline."""
    box = browser.value("player.getBoundingClientRect().toJSON()")
    inner = browser.value(f"{PAGE}.phonanim.timeline.canvas.getBoundingClientRect().toJSON()")
    left, top = box["x"] + inner["x"], box["y"] + inner["y"]
    for number, (x, y) in enumerate(points):
        kind = "mousePressed" if number == 0 else "mouseMoved"
        place = {"x": left + x, "y": top + y, "button": "left", "buttons": 1}
        browser.call("Input.dispatchMouseEvent", type=kind, clickCount=1, **place)
    browser.call("Input.dispatchMouseEvent", type="mouseReleased", clickCount=1, **place | {"buttons": 0})


def wait_for_take(browser: Browser, revision: int, what: str) -> None:
    """Until the line was made anew; prints how long that took, and the server's processor time."""
    output = f"{PAGE}.document.getElementById('said')"
    browser.wait(f"{PAGE}.phonanim.line.revision === {revision} || {output}.className")
    said = browser.value(f"{output}.textContent")
    if browser.value(f"{output}.className"):
        raise RuntimeError(f"{what}: {said}")
    spent = browser.value(f"{PAGE}.phonanim.line.spent")
    entry = f"{PAGE}.performance.getEntriesByType('resource').at(-1)"
    answered = browser.value(f"Math.round({entry}.responseEnd - {entry}.requestStart)")
    print(f"{what}: {said}; answered in {answered} ms, {spent} ms of processor time")


def correct(browser: Browser) -> None:
    """Correct the open line by mouse and keys, undo, and approve it."""
    phones = browser.value(f"{PAGE}.phonanim.takes[0].phones")
    place = next(number for number, phone in enumerate(phones) if phone[0] == "B")
    begin, end = phones[place][1:]
    x = browser.value(f"[{begin}, {begin - 0.06}, {end}].map((t) => {PAGE}.phonanim.timeline.x(t))")
    y = browser.value(
        f"(() => {{ const t = {PAGE}.phonanim.timeline; return 20 + (t.wave ? 46 : 0) + 24 + 12; }})()"
    )
    browser.wait(f"{PAGE}.phonanim.timeline.wave !== null")
    y = browser.value("20 + 46 + 24 + 12")
    drag(browser, [(x[0], y), ((x[0] + x[1]) / 2, y), (x[1], y)])
    wait_for_take(browser, 1, "a boundary was dragged")
    moved = browser.value(f"{PAGE}.phonanim.takes[0].phones")[place][1]
    if not abs(moved - (begin - 0.06)) < 0.02:
        raise RuntimeError(f"the boundary is at {moved:.3f} s, not at {begin - 0.06:.3f} s")
    press(browser, "h")
    wait_for_take(browser, 2, "lips were held")
    browser.value(f"{PAGE}.focus()")
    press(browser, "e")
    browser.wait(f"{PAGE}.document.querySelector('dialog input') !== null")
    browser.call("Input.insertText", text="P")
    press(browser, "Enter")
    wait_for_take(browser, 3, "a label was changed")
    press(browser, "d")
    area = browser.value(f"{PAGE}.phonanim.timeline.area")
    middle = area["top"] + area["height"] * 0.3
    drag(browser, [(x[2] + 20 * step, middle + 3 * step) for step in range(8)])
    wait_for_take(browser, 4, "a curve was drawn")
    press(browser, "d")
    press(browser, "s")
    style = f"{PAGE}.document.querySelector('#settings select')"
    browser.value(f"{style}.value = 'clear'; {style}.dispatchEvent(new Event('change'))")
    wait_for_take(browser, 5, "a style was set")
    browser.value(f"{PAGE}.document.activeElement.blur()")
    press(browser, "s")
    press(browser, "u")
    wait_for_take(browser, 6, "the style was undone")
    press(browser, "a")
    wait_for_take(browser, 7, "approved")
    browser.wait("lines[playing].decision === 'approved'")
    line = browser.value(f"{PAGE}.phonanim.line")
    if (line["status"], line["style"], len(line["drawn"])) != ("approved", "", 1):
        raise RuntimeError(f"the line is not as it was left: {line}")


def take_pictures(browser: Browser, folder: Path) -> None:
    """The page at 1280 and at 390 pixels, with and without the settings."""
    for width in (1280, 390):
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
        browser.call("Emulation.setDeviceMetricsOverride", **size)
        time.sleep(1.5)
        browser.picture(folder / f"review{width}.png")
        press(browser, "s")
        time.sleep(1)
        browser.picture(folder / f"review{width}settings.png")
        press(browser, "s")
        if browser.value("document.documentElement.scrollWidth") > width:
            raise RuntimeError(f"the page is wider than {width} pixels")


def resident_memory(parent: int) -> float:
    """MB of the largest process that shows a page, below a Chromium."""
    found = [0.0]
    for path in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if b"--type=renderer" in (path / "cmdline").read_bytes() and parent in ancestors(path.name):
                rollup = (path / "smaps_rollup").read_text()
                found.append(int(rollup.split("Pss:")[1].split()[0]) / 1e3)
    return max(found)


def ancestors(process: str) -> list[int]:
    """The processes above one."""
    found: list[int] = []
    while process != "0":
        process = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1]
        found.append(int(process))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--lines", type=int, default=10000)
    options = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        print("needs chromium or google-chrome", file=sys.stderr)
        return 1
    source, made = options.output / "lines", options.output / "run"
    shutil.rmtree(made, ignore_errors=True)
    source.mkdir(parents=True, exist_ok=True)
    for name in ("line.TextGrid", "line.wav"):
        shutil.copy(ROOT / "examples" / name, source)
    arguments = ["batch", str(source), "-o", str(made), "--format", "npz", "-q", "--workers", "1"]
    if run(arguments):
        return 1
    lines = lines_of_run(made)
    review = many(open_review(made.absolute(), lines), options.lines)
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile,
        ReviewServer(review, "t", who="Ann") as server,
    ):
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = Browser(program, profile, options.output)
        try:
            look(browser, server.address, options.lines)
            correct(browser)
            print(f"{resident_memory(browser.process.pid):.0f} MB in the page's process with the line open")
            take_pictures(browser, options.output)
        except RuntimeError as error:
            browser.picture(options.output / "failed.png")
            print(error, file=sys.stderr)
            return 1
        finally:
            browser.close()
            server.shutdown()
    return check_next_batch(arguments, made)


def check_next_batch(arguments: list[str], made: Path) -> int:
    """The next run has what was corrected."""
    before = (made / "line.npz").read_bytes()
    if run(arguments):
        return 1
    labels = [phone.label for phone in load(made / "line.npz").phones]
    if (made / "line.npz").read_bytes() == before or "P" not in labels:
        print("the next batch does not have what was corrected", file=sys.stderr)
        return 1
    print("the next batch has what was corrected")
    return 0


if __name__ == "__main__":
    sys.exit(main())
