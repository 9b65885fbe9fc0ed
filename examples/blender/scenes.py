"""What a line has beside its curves: markers at phones, and its sound."""

import json
from pathlib import Path

import bpy

from .faces import KEPT, scene_rate
from .takes import Take


def mark_phones(take: Take, scene: bpy.types.Scene, first: float) -> int:
    """A marker at the start of each phone; those of an earlier take of this name go."""
    listed = json.loads(scene.get(KEPT, "{}"))  # markers have no custom properties
    before = {tuple(one) for one in listed.get(take.name, [])}
    for marker in [one for one in scene.timeline_markers if (one.name, one.frame) in before]:
        scene.timeline_markers.remove(marker)
    rate = scene_rate(scene)
    spoken = [(label, round(first + start * rate)) for label, start, _ in take.phones if label]
    made = [scene.timeline_markers.new(label, frame=frame) for label, frame in spoken]
    scene[KEPT] = json.dumps({**listed, take.name: [(one.name, one.frame) for one in made]})
    return len(made)


def lay_sound(take: Take, folder: Path, scene: bpy.types.Scene, first: float) -> bool:
    """The recording of a take, where it is in the folder, in the sequencer; an earlier one is replaced."""
    name = take.document.get("audio")
    if not name or not (folder / name).is_file():
        return False
    sequence = scene.sequence_editor or scene.sequence_editor_create()
    for strip in [one for one in sequence.strips if one.name == take.name]:
        sequence.strips.remove(strip)
    channel = 1 + max((strip.channel for strip in sequence.strips), default=0)
    sequence.strips.new_sound(take.name, str(folder / name), channel, round(first))
    return True
