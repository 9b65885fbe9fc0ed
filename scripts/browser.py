"""Headless Chromium for the checks of pages: one page, spoken to over a pipe in the DevTools protocol."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def open_browser(output: Path) -> Iterator[Browser]:
    """A page whose downloads go to `output`, which is made; where a check fails, failed.png shows the page.

    Raises RuntimeError without Chromium.
    """
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        raise RuntimeError("needs chromium or google-chrome")
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile, output)
        try:
            yield browser
        except RuntimeError:
            browser.picture(output / "failed.png")
            raise
        finally:
            browser.close()
