"""A review in headless Chromium: a line is found, corrected, approved, and in the next batch."""

import shutil
import subprocess
import sys

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (shutil.which("chromium") or shutil.which("google-chrome")),
        reason="needs chromium or google-chrome",
    ),
]


def test_a_line_is_found_corrected_and_approved(root, tmp_path):
    given = [sys.executable, str(root / "scripts/check_review.py"), "-o", str(tmp_path), "--lines", "200"]
    done = subprocess.run(given, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    for step in ("a boundary was dragged", "a curve was drawn", "approved", "the next batch has"):
        assert step in done.stdout
