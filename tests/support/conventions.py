"""Heads for tests: the shipped one under the names of shapes that programs and conventions use."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from phonanim.core.lexicon import LEXICON
from phonanim.media.glb import glb_bytes, read_glb
from phonanim.rig.align import add_viseme_shapes
from phonanim.rig.head import TONGUE, Head, load_head
from phonanim.rig.meshes import write_head

NAMES = LEXICON / "rigs" / "names"
MAKERS: dict[str, Callable[[], Head]] = {}
"""A head for each convention, by its name."""


def renamed(rename: Callable[[str], str]) -> Head:
    """The shipped head with its ARKit shapes under other names."""
    head = load_head().without(TONGUE)
    return replace(head, targets=tuple(map(rename, head.targets)))


def sided(name: str) -> str:
    """`jawLeft` as `jaw_L`, as Blender writes it."""
    return (
        name.removesuffix("Left") + "_L"
        if name.endswith("Left")
        else name.removesuffix("Right") + "_R"
        if name.endswith("Right")
        else name
    )


def from_table(table: str, keep: str, rest: Callable[[str], str] | None = None) -> Head:
    """A head whose shapes are those of a table of names that begin with `keep`.

    A control with several shapes is divided among them; controls that the table lacks are named by `rest`.
    """
    with (NAMES / f"{table}.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["shape"].startswith(tuple(keep.split()))]
    whole = add_viseme_shapes(load_head().without(TONGUE))
    shapes: dict[str, np.ndarray] = {}
    for row in rows:
        sharers = [other for other in rows if other["control"] == row["control"]]
        if row["control"] in whole.targets and row["shape"] not in shapes:
            shapes[row["shape"]] = whole.deltas[whole.targets.index(row["control"])] / len(sharers)
    if rest is not None:
        known = {row["control"] for row in rows}
        head = load_head().without((*TONGUE, *known))
        shapes |= {rest(name): move for name, move in zip(head.targets, head.deltas, strict=True)}
    return replace(whole, targets=tuple(shapes), deltas=np.array(list(shapes.values())))


def big_eyed(head: Head) -> Head:
    """The head with everything above the mouth growing, its crown by half."""
    eye, mouth = _middle(head, "eye_l")[1], _middle(head, "teeth_u")[1]
    scale = 1 + 0.35 * np.clip((head.vertices[:, 1:2] - mouth) / (eye - mouth), 0, 1.5)
    about = np.array([0, mouth, 0])
    return replace(head, vertices=(head.vertices - about) * scale + about, deltas=head.deltas * scale)


def long_chinned(head: Head) -> Head:
    """The head with a chin that reaches 25 mm farther down and 8 mm forward."""
    below = _middle(head, "teeth_l")[1] - 0.015 - head.vertices[:, 1]
    share = np.clip(below / 0.04, 0, 1) * (head.vertices[:, 2] > 0)
    return replace(head, vertices=head.vertices + np.outer(share, [0, -0.025, 0.008]))


def lying(head: Head) -> Head:
    """The head in centimetres, z up."""
    turn = 100 * np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    return replace(head, vertices=head.vertices @ turn.T, deltas=head.deltas @ turn.T)


def _middle(head: Head, part: str) -> np.ndarray:
    return np.asarray(head.vertices[head.parts[part]].mean(axis=0))


STYLES = {"big eyes": big_eyed, "long chin": long_chinned, "centimetres, z up": lying}
"""Stylized proportions, and another scale and axes, by name."""


def one_shape() -> Head:
    """A head with `mouthOpen` and `mouthSmile` alone, the default of Ready Player Me."""
    head = load_head()
    at = head.targets.index
    smile = head.deltas[at("mouthSmileLeft")] + head.deltas[at("mouthSmileRight")]
    return replace(
        head, targets=("mouthOpen", "mouthSmile"), deltas=np.array([head.deltas[at("jawOpen")], smile])
    )


def capitals(name: str) -> str:
    """`mouthSmileLeft` as `Mouth_Smile_L`."""
    words = "".join(f"_{letter}" if letter.isupper() else letter for letter in name)
    return sided(words.replace("_Left", "Left").replace("_Right", "Right")).title().replace(" ", "_")


MAKERS |= {
    "BS_": lambda: renamed(lambda name: f"BS_{name}"),
    "Head_baseMesh.": lambda: renamed(lambda name: f"Head_baseMesh.{name}"),
    "Blender _001": lambda: renamed(lambda name: f"{sided(name)}_001"),
    "Maya": lambda: renamed(lambda name: f"hero:blendShape1_{name[0].upper()}{name[1:]}"),
    "accessors": lambda: renamed(lambda name: f"face.{name}"),
    "Reallusion": lambda: from_table("reallusion", "Mouth Jaw Brow Cheek Eye", capitals),
    "DAZ Genesis 8.1": lambda: renamed(
        lambda name: f"Genesis8_1Female__facs_bs_{name[0].upper()}{name[1:]}_div2"
    ),
    "DAZ Genesis 8": lambda: from_table("daz", "eCTRL"),
    "VRChat": lambda: from_table("vrchat", "vrc.v_"),
    "Oculus": lambda: from_table("oculus", "sil PP FF TH DD kk CH SS nn RR aa E ih oh ou"),
    "VRoid": lambda: from_table("vroid", "Fcl_"),
    "MMD": lambda: from_table("mmd", "あ い う え お まばたき ウィンク"),
    "Rocketbox": lambda: from_table("rocketbox", "AA_VI"),
    "Ready Player Me": one_shape,
}


def write_convention(name: str, path: Path) -> Path:
    """Write the head of a convention as GLB."""
    write_head(path, MAKERS[name]())
    if name == "accessors":
        glb = read_glb(path)
        tree = json.loads(json.dumps(glb.tree))
        for mesh in tree["meshes"]:
            names = mesh.pop("extras")["targetNames"]
            for part in mesh["primitives"]:
                for target, shape in zip(part["targets"], names, strict=True):
                    tree["accessors"][target["POSITION"]]["name"] = shape
        path.write_bytes(glb_bytes(tree, glb.binary))
    return path
