"""Take part in a study as a person would, in headless Chromium, from the first click to the last file.

    python scripts/check_study.py study.html -o work/check [--prefer ours] [--careless] [--speed 8]

Every film is played to its end; the first trial is done with the mouse, the others with the keyboard.
After two trials the page is loaded anew and must go on where it was. The downloaded answers and pictures
of the page are left in the output folder; the path of the answers is printed. `--careless` answers the
controls wrongly. Exit code 1, with one line, when the page misbehaves.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from browser import PATIENCE, Browser, open_browser


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
    try:
        with open_browser(options.output) as browser:
            print(take_part(browser, options.page, options.output, options))
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
