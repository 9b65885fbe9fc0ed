"""Watch the live page of `phonanim stream --to websocket` in headless Chromium.

    python scripts/check_live.py -o work/check [--port 8799]

Streams the example line, as often as it takes, and waits until the page has shown frames of it; then a
picture is taken. Then `--view` must wait for the page, its sound stay in step, and the face go to rest when
the stream is interrupted. Exit code 1, with one line, when the page does not.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from browser import Browser

from phonanim.inputs.alignment import read_alignment

ROOT = Path(__file__).resolve().parent.parent
TIMES = 20  # the line is said so often
FRAMES = 30  # pictures that must have been drawn
AT_REST = "values.every((value, i) => Math.abs(value - data.rest[i]) < 0.01)"
JAW = "stage.heads[0].morphs.find(({ channel }) => data.channels[channel] === 'jawOpen')"


def lines() -> str:
    """The example line as events, again and again."""
    line = read_alignment(ROOT / "examples" / "line.TextGrid")
    told = [
        {"phone": phone.label, "start": phone.start + n * line.duration, "end": phone.end + n * line.duration}
        for n in range(TIMES)
        for phone in line.intervals
    ]
    return "\n".join(map(json.dumps, told)) + "\n"


def watch(browser: Browser, port: int, picture: Path) -> int:
    """Frames that the page drew of those that came."""
    browser.call("Page.navigate", url=f"http://127.0.0.1:{port}/")
    browser.wait("typeof last === 'object' && last !== null && stage.heads.length === 1")
    seen, most = set(), 0.0
    end = time.monotonic() + 60
    while len(seen) < FRAMES or most < 0.1:
        if time.monotonic() > end:
            raise RuntimeError(f"the page drew {len(seen)} frames, the jaw opened by {most:.2f}")
        seen.add(browser.value("document.documentElement.dataset.frame"))
        most = max(most, browser.value(f"(({JAW}).part.morphTargetInfluences[({JAW}).target])"))
        if most >= 0.1 and not picture.exists():
            browser.picture(picture)
    return len(seen)


def watch_view(browser: Browser, port: int) -> None:
    """A stream with sound that begins when the page is ready, and is interrupted."""
    line = str(ROOT / "examples" / "line.TextGrid")
    command = [sys.executable, str(ROOT / "cli.py"), "stream", line, "--to", f"websocket={port}", "--view"]
    stream = subprocess.Popen(
        command, env={**os.environ, "BROWSER": "true"}, stderr=subprocess.PIPE, text=True
    )
    try:
        assert stream.stderr
        while "waiting for" not in stream.stderr.readline():
            if stream.poll() is not None:
                raise RuntimeError("the stream did not wait for its page")
        browser.call("Page.navigate", url=f"http://127.0.0.1:{port}/")
        browser.wait("typeof socket === 'object' && socket?.readyState === 1 && stage.heads.length === 1")
        if browser.value("last !== null"):
            raise RuntimeError("the stream did not wait for its page")
        browser.press("begin")
        browser.wait("last !== null && last.time > 1")
        away = max(abs(browser.value("sound.currentTime - last.time")) for _ in range(20))
        print(f"the sound is at most {1000 * away:.0f} ms away from the frames")
        if away > 0.3:
            raise RuntimeError("the sound is not in step")
        stream.send_signal(signal.SIGINT)
        browser.wait(f"document.getElementById('state').dataset.live === 'false' && {AT_REST}")
        print("the face went to rest")
    finally:
        stream.kill()
        stream.wait()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--port", type=int, default=8799)
    options = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        print("needs chromium or google-chrome", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    picture = options.output / "live.png"
    picture.unlink(missing_ok=True)
    command = [sys.executable, ROOT / "cli.py", "stream", "--realtime", "--to", f"websocket={options.port}"]
    stream = subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, text=True)
    assert stream.stdin
    stream.stdin.write(lines())
    stream.stdin.close()
    time.sleep(2)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile, options.output)
        try:
            print(f"{watch(browser, options.port, picture)} frames seen, {picture}")
            watch_view(browser, options.port + 1)
        except RuntimeError as error:
            browser.picture(options.output / "failed.png")
            print(error, file=sys.stderr)
            return 1
        finally:
            stream.terminate()
            browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
