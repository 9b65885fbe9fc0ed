import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from animations import line

from phonanim.errors import OutputError, RigError
from phonanim.exporters import load, save
from phonanim.exporters._usd_stage import stage_text
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.head import SHIPPED, load_head
from phonanim.rig.neck import TURNS, turned

Usd = pytest.importorskip("pxr.Usd", reason="needs the extra usd")
Vt = pytest.importorskip("pxr.Vt", reason="needs the extra usd")
UsdSkel = pytest.importorskip("pxr.UsdSkel", reason="needs the extra usd")


@pytest.fixture(scope="module", params=[".usda", ".usdc"])
def stage(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("usd") / f"hello{request.param}"
    save(turning(), path)
    return Usd.Stage.Open(str(path))


def test_the_validator_finds_nothing(stage):
    validation = pytest.importorskip("pxr.UsdValidation", reason="needs usd-core 24.11 or newer")
    validators = validation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 10
    found = validation.ValidationContext(validators).Validate(stage)
    assert [error.GetMessage() for error in found] == []


def test_the_points_are_those_of_the_head(stage):
    """Blend shapes applied by UsdSkel's own query, on the skin at one frame, against Head.shape."""
    head = load_head()
    frame = 17
    weights = head.weights(line().values, line().channels)[frame]
    skin = stage.GetPrimAtPath("/head/skin")
    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(skin))
    names = UsdSkel.BindingAPI(skin).GetBlendShapesAttr().Get()
    by_name = dict(zip(head.targets, weights.tolist(), strict=True))
    subs = query.ComputeSubShapeWeights([by_name[str(name)] for name in names])
    points = np.array(skin.GetAttribute("points").Get(), np.float32)
    moved = points.copy()
    offsets = query.ComputeSubShapePointOffsets()
    rows = query.ComputeBlendShapePointIndices()
    for weight, shape, sub in zip(*subs[:3], strict=True):
        moved[np.array(rows[shape])] += weight * np.array(offsets[sub])
    np.testing.assert_allclose(moved, head.shape(weights)[head.parts["skin"]], atol=2e-5)


def turning():
    """The line, with a head that turns."""
    take = line()
    angle = 10 * np.sin(np.arange(len(take.values)) / 5)
    turns = np.stack([angle, 0.7 * angle + 1, -0.4 * angle], axis=1)
    values = take.values.copy()
    values[:, [take.channels.index(name) for name in TURNS]] = turns
    return take.with_values(values)


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_the_head_turns_and_is_read_back(tmp_path, suffix):
    """Points by UsdSkel's own skinning, against the head as the film draws it."""
    take, path, frame = turning(), tmp_path / f"a{suffix}", 17
    save(take, path)
    again = load(path)
    assert again.channels[-3:] == TURNS
    np.testing.assert_allclose(again.values[:, -3:], take.values[:, -3:], atol=2e-5)
    stage = Usd.Stage.Open(str(path))
    cache = UsdSkel.Cache()
    root = UsdSkel.Root(stage.GetPrimAtPath("/head"))
    assert cache.Populate(root, Usd.PrimDefaultPredicate)
    skin = stage.GetPrimAtPath("/head/skin")
    skeleton = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/head/skeleton")))
    moves = skeleton.ComputeSkinningTransforms(frame)
    rest = np.array(skin.GetAttribute("points").Get())
    points = Vt.Vec3fArray.FromNumpy(rest)
    assert cache.GetSkinningQuery(skin).ComputeSkinnedPoints(moves, points, frame)
    head = load_head()
    expected = turned(head.vertices, head.neck, take.values[frame, -3:].astype(float))[head.parts["skin"]]
    assert np.abs(expected - rest).max() > 0.005
    np.testing.assert_allclose(np.array(points), expected, atol=2e-6)


def test_a_character_turns_by_its_bone(tmp_path):
    hero, take = tmp_path / "hero.glb", turning()
    hero.write_bytes(SHIPPED.read_bytes())
    save(take, tmp_path / "a.usda", character=hero)
    np.testing.assert_allclose(load(tmp_path / "a.usda").values[:, -3:], take.values[:, -3:], atol=2e-5)
    glb = read_glb(hero)
    for node in glb.tree["nodes"]:
        node["name"] = "x"  # no bone is called head
    hero.write_bytes(glb_bytes(glb.tree, glb.binary))
    save(take, tmp_path / "a.usda", character=hero)
    assert "rotations" not in (tmp_path / "a.usda").read_text()


def test_weights_are_sampled_at_every_frame(stage):
    attribute = UsdSkel.Animation(stage.GetPrimAtPath("/head/speech")).GetBlendShapeWeightsAttr()
    assert attribute.GetTimeSamples() == list(range(61))
    assert stage.GetTimeCodesPerSecond() == 60
    weights = load_head().weights(line().values, line().channels)
    np.testing.assert_allclose(attribute.Get(30), weights[30], atol=1e-7)


def test_a_start_offset(tmp_path):
    save(replace(line(), start=2.0), tmp_path / "a.usda")
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (120, 180)
    assert load(tmp_path / "a.usda").start == 2.0


def test_the_same_text_twice():
    assert [*stage_text(line())] == [*stage_text(line())]


def test_stages_that_hold_no_animation(tmp_path):
    path = tmp_path / "a.usda"
    path.write_text("#usda 1.0\n")
    with pytest.raises(OutputError, match=r"a\.usda: has no SkelAnimation of blend shape weights; export it"):
        load(path)
    path = tmp_path / "b.usda"
    path.write_text("no stage")
    with pytest.raises(OutputError, match=r"b\.usda: is not a readable USD stage"):
        load(path)
    path = tmp_path / "c.usda"
    path.write_text(
        '#usda 1.0\ndef SkelAnimation "a"\n{\n    uniform token[] blendShapes = ["a", "b"]\n'
        "    float[] blendShapeWeights.timeSamples = {\n        0: [1],\n        1: [1],\n    }\n}\n"
    )
    with pytest.raises(OutputError, match=r"c\.usda: 2 blend shapes have 1 weights; export it again"):
        load(path)


def test_numbered_weights_are_those_of_their_shapes(tmp_path):
    """As Blender writes shapes that several meshes share: a weight for each, numbered, in one animation."""
    path = tmp_path / "a.usda"
    path.write_text(NUMBERED.format("0.5"))
    again = load(path)
    assert again.channels == ("jawOpen", "x1")
    np.testing.assert_allclose(again.values, [[0, 1], [0.5, 1]])
    path.write_text(NUMBERED.format("0.7"))
    with pytest.raises(
        OutputError, match=r"a\.usda: two of its meshes move jawOpen differently; key them alike"
    ):
        load(path)


def test_rigs_that_the_head_does_not_know(tmp_path):
    with pytest.raises(RigError, match=r"the head has none of the channels x0, x1, x2, x3"):
        save(replace(line(), channels=tuple(f"x{i}" for i in range(52))), tmp_path / "a.usda")


NUMBERED = """#usda 1.0
def SkelAnimation "speech"
{{
    uniform token[] blendShapes = ["jawOpen", "jawOpen2", "x1"]
    float[] blendShapeWeights.timeSamples = {{
        0: [0, 0, 1],
        1: [0.5, {}, 1],
    }}
}}
def Mesh "teeth" (
    prepend apiSchemas = ["SkelBindingAPI"]
)
{{
    uniform token[] skel:blendShapes = ["jawOpen2", "x1"]
    rel skel:blendShapeTargets = [</teeth/jawOpen>, </teeth/x1>]
    def BlendShape "jawOpen"
    {{
    }}
    def BlendShape "x1"
    {{
    }}
}}
"""
LIMITED = """
import resource, signal, sys
sys.path[:0] = [{tests!r}, {root!r}]
from pathlib import Path
from animations import line
from phonanim.exporters import save
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
try:
    save(line(), Path({path!r}))
except Exception as error:
    print(type(error).__name__, error)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs limits on the size of files")
def test_a_full_temporary_folder(tmp_path, root):
    support, path = str(root / "tests" / "support"), str(tmp_path / "a.usdc")
    code = LIMITED.format(tests=support, root=str(root), path=path)
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    assert re.match(r"OutputError .*a\.usdc: the USD library cannot write to .*; free space there", said)
    assert not list(tmp_path.iterdir())


def test_curves_alone_are_a_stage_of_a_few_percent(tmp_path):
    save(turning(), tmp_path / "whole.usda")
    save(turning(), tmp_path / "a.curves.usda")
    stage = Usd.Stage.Open(str(tmp_path / "a.curves.usda"))
    assert [prim.GetTypeName() for prim in stage.Traverse()] == ["SkelAnimation"]
    animation = UsdSkel.Animation(stage.GetDefaultPrim())
    shapes = [str(name) for name in animation.GetBlendShapesAttr().Get()]
    assert "jawOpen" in shapes
    assert not set(TURNS) & set(shapes)
    np.testing.assert_array_equal(
        np.array(animation.GetBlendShapeWeightsAttr().Get(17), np.float32)[shapes.index("jawOpen")],
        turning().channel("jawOpen")[17],
    )
    sizes = [(tmp_path / name).stat().st_size for name in ("a.curves.usda", "whole.usda")]
    assert sizes[0] < 0.05 * sizes[1]
