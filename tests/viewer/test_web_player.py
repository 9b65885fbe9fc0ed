import json
import re
import shutil
import subprocess

import pytest
from animations import line

from phonanim.exporters import save
from phonanim.rig.morphs import plain_name

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="needs node")


@pytest.fixture
def module(root):
    return root / "examples" / "web" / "phonanim-player.js"


def test_the_player_on_stub_meshes(root, module):
    done = subprocess.run(
        [NODE, root / "tests/viewer/player.mjs", module], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "13 tests\n"


def evaluate(module, code, *arguments):
    """What JavaScript prints as JSON, with the module as `player`."""
    script = f"const player = await import('{module.as_uri()}'); const given = process.argv.slice(1);\n{code}"
    done = subprocess.run(
        [NODE, "--input-type=module", "-e", script, *arguments], capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def test_tracks_that_are_written_are_played(tmp_path, module):
    save(line(), tmp_path / "a.track.json")
    code = """
        const fs = await import("node:fs");
        const track = player.parseTrack(JSON.parse(fs.readFileSync(given[0])));
        const jaw = track.channels.find(({ name }) => name === "jawOpen");
        console.log(JSON.stringify(Array.from({ length: 61 }, (_, n) => player.valueAt(jaw, n / 60))));
    """
    shown = evaluate(module, code, str(tmp_path / "a.track.json"))
    assert shown == pytest.approx(line().channel("jawOpen").tolist(), abs=0.004)


def test_names_match_as_in_the_exporters(module):
    names = ["jawOpen", "BS.jaw_open", "eyeBlink_L", "mouthRoll", "eyeBlinkR", "a_l", "L", "aaR", "Jaw Open"]
    names += ["eyeBlink.L", "jaw-open_001", "jawOpen_div2", "jawOpen.001", ".001"]
    code = "console.log(JSON.stringify(given.map(player.plainName)));"
    assert evaluate(module, code, *names) == [plain_name(name) for name in names]


def test_the_page_uses_what_the_module_has(module):
    page = (module.parent / "index.html").read_text("utf-8")
    named = re.search(r'import \{ (.*) \} from "\./phonanim-player\.js"', page)[1].split(", ")
    exported = re.findall(
        r"^export (?:async )?(?:function|class) (\w+)", module.read_text("utf-8"), re.MULTILINE
    )
    assert set(named) <= set(exported)
    package = json.loads((module.parent / "package.json").read_text("utf-8"))
    assert package["exports"] == "./phonanim-player.js"
