"""Take part in a study as a person would, in headless Chromium, from the first click to the last file.

    python scripts/check_study.py study.html -o work/check [--prefer ours] [--careless] [--speed 8]

Every film is played to its end; the first trial is done with the mouse, the others with the keyboard.
After two trials the page is loaded anew and must go on where it was. The downloaded answers and pictures
of the page are left in the output folder; the path of the answers is printed. `--careless` answers the
controls wrongly. Exit code 1, with one line, when the page misbehaves.
"""

from __future__ import annotations

import argparse
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

PATIENCE = 60.0  # seconds for anything that the page does
KEYS = {
    "both": (" ", "Space", 32),
    "begin": (" ", "Space", 32),
    "start": ("Enter", "Enter", 13),
    "next": ("Enter", "Enter", 13),
    "download": ("Enter", "Enter", 13),
    "choose-left": ("ArrowLeft", "ArrowLeft", 37),
    "choose-right": ("ArrowRight", "ArrowRight", 39),
    "choose-third": ("ArrowDown", "ArrowDown", 40),
    **{f"star-{star}": (f"{star}", f"Digit{star}", 48 + star) for star in range(1, 6)},
}


class Browser:
    """One page in headless Chromium, spoken to over a pipe in the DevTools protocol."""

    def __init__(self, program: str, profile: str, downloads: Path) -> None:
        out_read, self.write = os.pipe()
        self.read, in_write = os.pipe()
        command = [program, "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe"]
        command += [f"--user-data-dir={profile}", "--window-size=1000,900", "about:blank"]
        # Chromium reads its orders from descriptor 3 and answers on 4.
        shell = f'exec "$@" 3<&{out_read} 4>&{in_write}'
        self.process = subprocess.Popen(
            ["bash", "-c", shell, "bash", *command],
            pass_fds=(out_read, in_write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(out_read)
        os.close(in_write)
        self.buffer, self.count, self.session = b"", 0, ""
        pages = self.call("Target.getTargets")["targetInfos"]
        target = next(page["targetId"] for page in pages if page["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads.resolve()))
        self.session = attached["sessionId"]

    def call(self, method: str, **params: Any) -> Any:
        """Do one thing, and return what Chromium says of it."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            reply = self.receive()
            if reply.get("id") == self.count:
                if "error" in reply:
                    raise RuntimeError(f"{method}: {reply['error']['message']}")
                return reply["result"]

    def receive(self) -> Any:
        """The next message of Chromium."""
        while b"\0" not in self.buffer:
            data = os.read(self.read, 1 << 16)
            if not data:
                raise RuntimeError("Chromium has closed")
            self.buffer += data
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def value(self, expression: str) -> Any:
        """What a JavaScript expression is in the page."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{expression}: {result['exceptionDetails']['exception']['description']}")
        return result["result"].get("value")

    def wait(self, expression: str) -> None:
        """Until a JavaScript expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.value(expression):
            if time.monotonic() > end:
                raise RuntimeError(f"waited {PATIENCE:.0f} s in vain for {expression}")
            time.sleep(0.05)

    def press(self, button: str) -> None:
        """Press the key of a button."""
        key, code, number = KEYS[button]
        text = {"Enter": "\r"}.get(key, key if len(key) == 1 else "")
        event = {"key": key, "code": code, "windowsVirtualKeyCode": number}
        self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **event)
        self.call("Input.dispatchKeyEvent", type="keyUp", **event)

    def click(self, button: str) -> None:
        """Click on a button with the mouse."""
        element = f"document.getElementById('{button}')"
        self.value(f"{element}.scrollIntoView()")
        box = self.value(f"{element}.getBoundingClientRect().toJSON()")
        place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, button="left", clickCount=1, **place)

    def picture(self, path: Path) -> None:
        """A picture of the page, as PNG."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def close(self) -> None:
        """End Chromium."""
        self.session = ""
        self.call("Browser.close")
        self.process.wait(timeout=30)


def open_page(browser: Browser, address: str, speed: float) -> None:
    browser.call("Page.navigate", url=address)
    browser.wait("document.readyState === 'complete' && typeof study === 'object'")
    browser.value(
        f"for (const video of document.querySelectorAll('video')) video.defaultPlaybackRate = {speed}"
    )


def come_back(browser: Browser, address: str, speed: float, expected: list[Any]) -> None:
    """Load the page anew, as a person does who comes back.

    Chromium may give the page a new process, which can look before the old one has handed over what it
    kept: a matter of milliseconds, so that the page is loaded again before it is blamed. It keeps nothing
    by itself before the start button, so that a look does not change what is kept.
    """
    end = time.monotonic() + PATIENCE
    while True:
        browser.call("Page.navigate", url="about:blank")
        open_page(browser, address, speed)
        found = browser.value("[state.answers.length, state.order]")
        if found == expected:
            return
        if time.monotonic() > end:
            raise RuntimeError(f"loaded anew, the page has {found[0]} of {expected[0]} answers")
        time.sleep(0.5)


def answer(browser: Browser, use: Callable[[str], None], prefer: str, careless: bool) -> None:
    """One trial: watch both films, choose, give stars, go on."""
    done = browser.value("state.answers.length")
    use("both")
    browser.wait("!document.getElementById('choose-left').disabled")
    trial, swapped = browser.value("Object.values(state.order[state.answers.length])")
    choice, stars = decide(browser.value(f"study.trials[{trial}]"), swapped, prefer, careless)
    for number in range(browser.value("study.questions.length")):
        use(choice)
        if browser.value("study.rating") and number == 0:
            use(f"star-{stars}")
        use("next")
    browser.wait(f"state.answers.length === {done + 1}")


def decide(trial: dict[str, Any], swapped: bool, prefer: str, careless: bool) -> tuple[str, int]:
    """The button of the choice, and how many stars."""
    expected = trial["expected"]
    if expected == "none" and not careless:
        return "choose-third", 1
    systems = [take["system"] for take in trial["takes"]]
    take = systems.index(prefer) if prefer in systems else 0
    if isinstance(expected, int):
        take = 1 - expected if careless else expected
    return ("choose-right" if (take == 0) == swapped else "choose-left"), 4


def take_part(browser: Browser, page: Path, folder: Path, options: argparse.Namespace) -> Path:
    """Go through the whole study; returns the downloaded answers."""
    address = f"{page.resolve().as_uri()}?participant={options.participant}"
    open_page(browser, address, options.speed)
    browser.picture(folder / "welcome.png")
    order = browser.value("state.order")
    browser.click("start")
    for number in range(len(order)):
        browser.wait("!document.getElementById('trial').hidden")
        if number == 2:
            come_back(browser, address, options.speed, [2, order])
            browser.press("start")
            browser.picture(folder / "trial.png")
        answer(browser, browser.press if number else browser.click, options.prefer, options.careless)
    browser.wait("!document.getElementById('done').hidden")
    if browser.value("study.post"):
        browser.wait("state.posted")
    browser.picture(folder / "done.png")
    answers = folder / browser.value("document.getElementById('download').download")
    answers.unlink(missing_ok=True)
    browser.press("download")
    end = time.monotonic() + PATIENCE
    while not answers.exists():
        if time.monotonic() > end:
            raise RuntimeError(f"{answers.name} was not downloaded")
        time.sleep(0.1)
    return answers


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--prefer", default="", help="the system that is chosen where it is shown")
    parser.add_argument("--careless", action="store_true", help="answer the controls wrongly")
    parser.add_argument("--speed", type=float, default=8.0, help="of the films")
    parser.add_argument("--participant", default="check")
    options = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        print("needs chromium or google-chrome", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile, options.output)
        try:
            print(take_part(browser, options.page, options.output, options))
        except RuntimeError as error:
            browser.picture(options.output / "failed.png")
            print(error, file=sys.stderr)
            return 1
        finally:
            browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
