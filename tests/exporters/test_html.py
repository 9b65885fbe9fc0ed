import base64
import json
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from animations import line, only

from phonanim.articulation import CHANNELS
from phonanim.errors import OutputError, RigError
from phonanim.exporters import html, save
from phonanim.exporters.html import SCRIPTS
from phonanim.rig.head import SHIPPED, load_head

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
browser = pytest.mark.skipif(CHROMIUM is None, reason="needs chromium or google-chrome")


def data_of(path):
    text = re.search(r'type="application/json">(.*?)</script>', path.read_text("utf-8"), re.DOTALL)[1]
    return json.loads(text)


def test_the_page_holds_everything(tmp_path):
    animation = replace(line(), audio=tmp_path / "a.wav")
    animation.audio.write_bytes(b"RIFF")
    save(animation, tmp_path / "a.html", beside=only(animation, jawOpen=0.5))
    data = data_of(tmp_path / "a.html")
    first, second = data["takes"]
    curves = np.frombuffer(base64.b64decode(first["curves"]), "<f4").reshape(-1, len(first["channels"]))
    np.testing.assert_array_equal(curves, animation.values)
    jaw = first["channels"].index("jawOpen")
    assert [jaw, 0, load_head().targets.index("jawOpen"), 1.0] in first["targets"]
    assert first["phones"][1] == ["HH", 0.1, 0.2]
    assert second["channels"] == first["channels"]
    assert data["audio"] == "data:audio/wav;base64," + base64.b64encode(b"RIFF").decode()
    assert base64.b64decode(data["head"]) == SHIPPED.read_bytes()


def test_articulation_follows_the_controls_in_millimetres(tmp_path):
    mouth = np.random.default_rng(0).normal(0, 5, (61, len(CHANNELS))).astype(np.float32)
    animation = replace(line(), articulation=mouth)
    save(animation, tmp_path / "a.html", beside=line())
    spoken, plain = data_of(tmp_path / "a.html")["takes"]
    curves = np.frombuffer(base64.b64decode(spoken["curves"]), "<f4").reshape(-1, len(spoken["channels"]))
    assert spoken["channels"][-len(CHANNELS) :] == [f"{name} mm" for name in CHANNELS]
    np.testing.assert_array_equal(curves[:, -len(CHANNELS) :], mouth)
    np.testing.assert_array_equal(curves[:, : -len(CHANNELS)], animation.values)
    assert spoken["targets"] == plain["targets"]
    assert plain["channels"] == spoken["channels"][: -len(CHANNELS)]


def test_nothing_is_fetched_and_nothing_breaks_out(tmp_path):
    animation = replace(line(), provenance={"input": "</script><b>.TextGrid"})
    save(animation, tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text("utf-8")
    assert not re.search(r'(src|href)="', page)
    assert "{{" not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert page.count("</script>") == 2
    assert "<title>&lt;/script&gt;" in page
    assert data_of(tmp_path / "a.html")["takes"][0]["name"] == "</script><b>.TextGrid"


def test_pages_that_cannot_be_made(tmp_path):
    with pytest.raises(
        RigError, match=r"head\.glb: has no morph target named like x0, x1, x2 \.\.\.; name a --character"
    ):
        save(replace(line(), channels=tuple(f"x{i}" for i in range(52))), tmp_path / "a.html")
    with pytest.raises(OutputError, match=r"a\.aiff: a browser plays \.wav .* \.webm; convert"):
        save(replace(line(), audio=tmp_path / "a.aiff"), tmp_path / "a.html")
    with pytest.raises(OutputError, match=r"a\.wav: cannot be read: No such file"):
        save(replace(line(), audio=tmp_path / "a.wav"), tmp_path / "a.html")
    assert not list(tmp_path.iterdir())


def test_the_scripts_are_those_of_the_folder(root):
    folder = root / "phonanim" / "viewer"
    assert {path.name for path in folder.glob("*.js")} == set(SCRIPTS)
    assert "The MIT License" in (folder / "three.js").read_text("utf-8")[:2000]


def opened(page, address, *options):
    """What the browser says of a page, once it has been drawn."""
    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--enable-unsafe-swiftshader",
        "--use-angle=swiftshader",
    ]
    command += ["--window-size=900,700", "--virtual-time-budget=5000", *options, page.as_uri() + address]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


@browser
def test_a_browser_draws_the_time_it_is_asked_for(tmp_path):
    save(line(), tmp_path / "a.html")
    document = opened(tmp_path / "a.html", "#t=0.55", "--dump-dom")
    assert 'data-drawn="0.550"' in document
    assert document.count('class="curve"') == 55


@browser
def test_the_lips_open_where_the_curves_say(tmp_path):
    images = pytest.importorskip("PIL.Image")
    pictures = []
    for opening in (0.0, 0.7):
        save(only(line(), jawOpen=opening), tmp_path / "a.html")
        opened(tmp_path / "a.html", "#t=0.5", f"--screenshot={tmp_path / 'a.png'}")
        with images.open(tmp_path / "a.png") as image:
            pictures.append(np.asarray(image.convert("L"), float)[60:380, :600])
    changed = np.argwhere(np.abs(pictures[0] - pictures[1]) > 40)
    assert len(changed) > 300
    row, column = np.median(changed, axis=0)
    assert row > 160  # the lower half of the face
    assert 250 < column < 380  # its middle


FIND = """
$("search").value = "mouthpu"; $("search").dispatchEvent(new Event("input"));
const seen = rows.filter(({ row }) => getComputedStyle(row).display !== "none");
document.documentElement.dataset.found = seen.map(({ name }) => name).join();
document.documentElement.dataset.high = $("stage").clientHeight;
"""


@browser
@pytest.mark.slow
@pytest.mark.parametrize(("size", "head"), [("1280,800", 280), ("844,390", 250), ("390,844", 280)])
def test_the_page_on_screens_of_three_sizes(tmp_path, monkeypatch, size, head):
    read = html.read_page_part
    monkeypatch.setattr(html, "read_page_part", lambda part: read(part) + FIND * (part == "player.js"))
    save(line(), tmp_path / "a.html")
    document = opened(tmp_path / "a.html", "#t=0.5", f"--window-size={size}", "--dump-dom")
    assert 'data-found="mouthPucker"' in document
    assert int(re.search(r'data-high="(\d+)"', document)[1]) >= head
