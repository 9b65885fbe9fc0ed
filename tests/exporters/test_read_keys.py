"""Maya and Unity animations, read as well as written."""

import numpy as np
import pytest
from animations import line

from phonanim.errors import OutputError
from phonanim.exporters import load, save

MAYA = """animVersion 1.1;
mayaVersion 2024;
timeUnit film;
linearUnit cm;
angularUnit deg;
startTime 0;
endTime 24;
anim jawOpen jawOpen face_bs 0 0 7;
animData {
  input time;
  output unitless;
  weighted 0;
  preInfinity constant;
  postInfinity constant;
  keys {
    0 0 linear linear 1 1 0;
    12 0.6 linear step 1 1 0;
    24 0.2 %s linear 1 1 0;
  }
}
anim mouthFunnel mouthFunnel face_bs 0 0 9;
animData {
  input time;
  output unitless;
  weighted 0;
  preInfinity constant;
  postInfinity constant;
  keys {
    0 0.3 linear linear 1 1 0;
  }
}
"""


@pytest.mark.parametrize("fps", [24, 25, 30000 / 1001, 60, 90])
@pytest.mark.parametrize(("suffix", "keys"), [(".anim", None), (".anim", 0.01), (".unity.anim", 0.01)])
def test_a_curve_is_the_same_within_its_key_tolerance(tmp_path, fps, suffix, keys):
    animation = line(frames=round(fps) + 1, fps=fps)
    path = tmp_path / f"a{suffix}"
    save(animation, path, **({} if keys is None else {"keys": keys}))
    again = load(path)
    assert again.fps == pytest.approx(fps, rel=1e-5)
    assert len(again.values) == len(animation.values)
    assert again.rig == "arkit"
    for name in again.channels:
        curve = animation.channel(name)
        np.testing.assert_allclose(again.channel(name), curve, rtol=0, atol=(keys or 0.0) + 1e-6)


def test_tangents_of_maya(tmp_path):
    path = tmp_path / "a.anim"
    path.write_text(MAYA % "linear")
    take = load(path)
    assert (take.channels, take.fps, len(take.values)) == (("jawOpen", "mouthFunnel"), 24.0, 25)
    jaw = take.channel("jawOpen")
    np.testing.assert_allclose(jaw[:13], np.linspace(0, 0.6, 13), atol=1e-6)
    np.testing.assert_allclose(jaw[12:24], 0.6, atol=1e-6)  # stepped
    assert jaw[24] == pytest.approx(0.2)
    np.testing.assert_allclose(take.channel("mouthFunnel"), 0.3, atol=1e-6)
    assert "notes" not in take.provenance
    path.write_text(MAYA % "spline")
    assert load(path).provenance["notes"] == [
        "jawOpen: tangents are read as splines through their keys; bake the curves for their exact form"
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("animVersion", "version", "does not begin with animVersion"),
        ("timeUnit film", "timeUnit fortnight", "its timeUnit is 'fortnight'"),
        ("12 0.6", "12 nan", "a key is not a finite number"),
        ("12 0.6", "-3 0.6", "jawOpen has keys that run backwards"),
        ("24 0.2", "9e9 0.2", "jawOpen has a key at a time"),
        ("12 0.6 linear step", "12", "is not a Maya animation file"),
        ("anim ", "anims ", "it has no curves with keys"),
    ],
)
def test_damaged_files_of_maya(tmp_path, old, new, message):
    (tmp_path / "a.anim").write_text((MAYA % "linear").replace(old, new))
    with pytest.raises(OutputError, match=r"a\.anim: is not a Maya animation file: ") as caught:
        load(tmp_path / "a.anim")
    assert message in str(caught.value)


def test_a_clip_of_unity_has_its_own_slopes_and_other_curves(tmp_path):
    path = tmp_path / "a.unity.anim"
    save(line(), path, keys=0.01)
    text = path.read_text()
    other = text[text.index("  - curve:") : text.index("  - curve:", text.index("  - curve:") + 5)]
    other = other.replace("attribute: blendShape.", "attribute: m_LocalScale.")
    text = text.replace("  m_FloatCurves:\n", "  m_FloatCurves:\n" + other, 1)
    path.write_text(text)
    assert load(path).channels == load_plain(tmp_path).channels
    steps = text.replace("outSlope: ", "outSlope: Infinity #")
    path.write_text(steps)
    held = load(path).channel("jawOpen")
    assert len(np.unique(held)) < len(np.unique(load_plain(tmp_path).channel("jawOpen")))


def load_plain(folder):
    save(line(), folder / "plain.unity.anim", keys=0.01)
    return load(folder / "plain.unity.anim")


def test_damaged_clips(tmp_path):
    path = tmp_path / "a.unity.anim"
    save(line(), path)
    text = path.read_text()
    for old, new in (
        ("m_FloatCurves", "m_Curves"),
        ("m_SampleRate: 60", "m_SampleRate: 0"),
        ("time: 0\n", "time: x\n"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(OutputError, match=r"a\.unity\.anim: is not a readable animation clip: "):
            load(path)
