"""Take an earlier run's animation out of a character's file, so that a second run replaces it."""

from __future__ import annotations

from typing import Any

from phonanim.media.glb import Glb

OURS = frozenset(("fps", "rig", "phones", "provenance"))  # what the extras of our animations have


def without_twin(glb: Glb, name: str) -> Glb:
    """The file without our animation of this name, and without its data if they come last."""
    listed = glb.tree.get("animations", [])
    twins = [one for one in listed if one.get("name") == name and _is_ours(one)]
    if not twins:
        return glb
    kept = [one for one in listed if one not in twins]
    tree = {**glb.tree, "animations": kept}
    accessors, views = glb.tree.get("accessors", []), glb.tree.get("bufferViews", [])
    used = sorted(_accessors(twins))
    first_accessor, first_view = len(accessors) - len(used), len(views) - len(used)
    last = used == list(range(first_accessor, len(accessors)))
    in_order = [accessors[n].get("bufferView") for n in used] == list(range(first_view, len(views)))
    if not (used and last and in_order) or any(n >= first_accessor for n in _accessors(kept)):
        return Glb(tree, glb.binary, glb.source)  # as another program has ordered them
    tree |= {"accessors": accessors[:first_accessor], "bufferViews": views[:first_view]}
    return Glb(tree, glb.binary[: views[first_view].get("byteOffset", 0)], glb.source)


def _is_ours(animation: dict[str, Any]) -> bool:
    extras = animation.get("extras")
    return isinstance(extras, dict) and set(extras) >= OURS


def _accessors(animations: list[dict[str, Any]]) -> set[int]:
    """The numbers of the accessors that animations use."""
    return {sampler[end] for one in animations for sampler in one["samplers"] for end in ("input", "output")}
