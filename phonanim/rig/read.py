"""Read and check rig files: TOML that an artist can write."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from phonanim.core.decode import DecodeError, read_toml
from phonanim.core.lexicon import find_tables
from phonanim.errors import RigError
from phonanim.rig.measures import read_measures
from phonanim.rig.rig import MEAN, POSES, Array, Rig, Through, Visemes
from phonanim.rig.tables import read_hinges, read_mixture, read_shapes, read_visemes

FILES = ("direct", "head", "landmarks", "mouth", "accents", "tongue", "visemes", "shapes")
TEXTS = ("name", "title", "source", "face", "through", "table", *FILES)
LARGEST = 1e6  # of a value of a control
KEYS = (
    *("name", "title", "source", "face", "head", "landmarks", "mouth", "accents", "tongue", "direct"),
    *("speech", "articulated"),
    *("through", "table", "visemes", "shapes", "stepped"),
    *("controls", "at_most", "shares", "poses"),
)


def rig_names() -> tuple[str, ...]:
    """The shipped rigs, then those on PHONANIM_PATH."""
    return tuple(find_tables("rigs"))


def load_rig(name: str | Path) -> Rig:
    """Read a rig: a shipped one or one on PHONANIM_PATH by its name, any other by the path of its TOML file.

    Raises:
        RigError: There is no such rig, or its file is wrong; the message states location and fix.

    Examples:
        >>> import phonanim
        >>> phonanim.load_rig("arkit").controls[:2]
        ('browDownLeft', 'browDownRight')
    """
    return _load(str(name), ())


def _load(name: str, before: tuple[Path, ...]) -> Rig:
    """Read a rig that the other rigs, from the first to the last, go through."""
    path = find_rig(name)
    if path.resolve() in before:
        raise RigError(f"{path}: goes through itself; name another rig")
    document = read_document(path)
    found = rig_problems(document)
    if found:
        more = f" (and {len(found) - 1} more: phonanim rig check {path})" if len(found) > 1 else ""
        raise RigError(f"{path}: {found[0]}{more}")
    return _build(document, path, (*before, path.resolve()))


def find_rig(name: str) -> Path:
    """The TOML file of a rig. Raises RigError, suggesting the nearest name."""
    known = find_tables("rigs")
    if name in known:
        return known[name]
    if Path(name).suffix == ".toml" and Path(name).is_file():
        return Path(name)
    raise RigError(
        f"there is no rig {name!r}{_hint(name, known)}; shipped are {', '.join(known)}, "
        "and any .toml file that `phonanim rig new` writes"
    )


def read_document(path: Path) -> dict[str, Any]:
    """The TOML of a rig, unchecked. Raises RigError."""
    try:
        return read_toml(path)
    except OSError as error:
        raise RigError(f"{path}: cannot be read: {error.strerror}") from error
    except DecodeError as error:
        raise RigError(f"{path}: {error}") from error


def rig_problems(document: dict[str, Any]) -> list[str]:
    """All errors of a rig document, each in one line with its fix; empty when it is valid."""
    unknown = [f"unknown key {key!r}{_hint(key, KEYS)}" for key in document if key not in KEYS]
    wrong = [line for key in document if (line := _type_problem(key, document[key]))]
    if wrong:
        return [*unknown, *wrong]
    controls = document.get("controls")
    if not isinstance(controls, dict) or not controls:
        return [*unknown, "needs a table [controls] with name = [minimum, rest, maximum]"]
    limits = [line for name, limit in controls.items() if (line := _limit_problem(name, limit))]
    if unknown or limits:
        return unknown + limits
    return [*_reference_problems(document, controls), *_pose_problems(document, controls)]


def rig_warnings(rig: Rig) -> list[str]:
    """Warnings about what is valid but looks unfinished: identical poses, controls that no pose moves."""
    table = {MEAN: rig.mean, **dict(zip(POSES, rig.poses, strict=False))}
    seen: dict[bytes, str] = {}
    found = []
    for pose, values in table.items():
        twin = seen.setdefault(np.round(values, 4).tobytes(), pose)
        if twin != pose:
            found.append(f"[poses.{pose}] is the same as [poses.{twin}]; is it filled in?")
    idle = [name for name in rig.speech if rig.posed and not _moves(rig, name)]
    if idle:
        found.append(f"no pose moves {', '.join(idle[:6])}{' ...' if len(idle) > 6 else ''}")
    return found


def _moves(rig: Rig, name: str) -> bool:
    column = rig.controls.index(name)
    return bool((np.append(rig.poses[:, column], rig.mean[column]) != rig.rest[column]).any())


def _type_problem(key: str, value: Any) -> str:
    """Type errors of the keys that are not tables of numbers."""
    if key in TEXTS and not isinstance(value, str):
        return f"{key} must be a text in quotes, not {type(value).__name__}"
    if key in FILES and (Path(value).is_absolute() or "\0" in value):
        return f"{key} must be the path of a file from the rig's folder, not {value!r:.80}"
    if key in ("stepped", "articulated") and not isinstance(value, bool):
        return f"{key} must be true or false, not {value!r:.80}"
    if key == "speech" and not (isinstance(value, list) and all(isinstance(name, str) for name in value)):
        return "speech must be a list of names"
    if key in ("at_most", "shares") and not (
        isinstance(value, dict) and all(isinstance(name, str) for name in value.values())
    ):
        return f"[{key}] must be a table of names"
    if key == "poses" and not (
        isinstance(value, dict) and all(isinstance(pose, dict) for pose in value.values())
    ):
        return "[poses] must hold a table for each pose"
    return ""


def _limit_problem(name: str, limit: Any) -> str:
    numeric = isinstance(limit, list) and len(limit) == 3 and all(_is_number(value) for value in limit)
    if not numeric:
        return f"[controls] {name} must be [minimum, rest, maximum], three numbers, not {limit!r}"
    if not limit[0] <= limit[1] <= limit[2]:
        return f"[controls] {name} = {limit}: must rise from minimum over rest to maximum"
    return ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST


def _reference_problems(document: dict[str, Any], controls: dict[str, Any]) -> list[str]:
    """Controls that other tables name but that are not defined."""
    pairs = document.get("at_most", {})
    named = [("at_most", name) for name in (*pairs, *pairs.values())]
    named += [("shares", name) for name in document.get("shares", {})]
    named += [("speech", name) for name in document.get("speech", [])]
    return [_unknown_control(place, name, controls) for place, name in named if name not in controls]


def _unknown_control(place: str, name: str, controls: Iterable[str]) -> str:
    return f"[{place}] names the control {name!r}, which is not in [controls]{_hint(name, controls)}"


def _pose_problems(document: dict[str, Any], controls: dict[str, Any]) -> list[str]:
    poses = document.get("poses", {})
    names = (MEAN, *POSES)
    found = [f"[poses.{key}] is not a pose{_hint(key, names)}" for key in poses if key not in names]
    if not poses and {"direct", "through", "visemes", "mouth", "articulated"} & set(document):
        return []
    if not poses:
        found = ["needs [poses.*], a direct map, visemes, or a rig to go through"]
    found += [f"[poses.{key}] is missing: {looks}" for key, looks in POSES.items() if key not in poses]
    written = [(pose, name, value) for pose in names for name, value in poses.get(pose, {}).items()]
    return found + [line for place in written if (line := _value_problem(*place, controls))]


def _value_problem(pose: str, name: str, value: Any, controls: dict[str, Any]) -> str:
    place = f"poses.{pose}"
    if name not in controls:
        return _unknown_control(place, name, controls)
    if not _is_number(value):
        return f"[{place}] {name} must be a number, not {value!r}"
    minimum, _, maximum = controls[name]
    if not minimum <= value <= maximum:
        return f"[{place}] {name} = {value} is outside its limits {minimum} to {maximum}; change one of them"
    return ""


def _hint(name: str, names: Iterable[str]) -> str:
    near = get_close_matches(name, list(names), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def _build(document: dict[str, Any], path: Path, chain: tuple[Path, ...]) -> Rig:
    controls = tuple(document["controls"])
    minimum, rest, maximum = np.array(list(document["controls"].values()), np.float64).T
    mean, poses = _poses(document, controls, rest)
    files = {key: path.parent / document[key] for key in FILES if key in document}
    return Rig(
        name=str(document.get("name", path.stem)),
        title=str(document.get("title", "")),
        source=str(document.get("source", "")),
        controls=controls,
        minimum=minimum,
        maximum=maximum,
        rest=rest,
        mean=mean,
        poses=poses,
        face=str(document.get("face", "")),
        speech=tuple(document.get("speech", controls)),
        at_most=tuple((controls.index(a), controls.index(b)) for a, b in document.get("at_most", {}).items()),
        direct=read_hinges(files["direct"], controls) if "direct" in files else None,
        through=_through(document, path, controls, chain),
        visemes=_visemes(document, files, controls),
        head=files.get("head"),
        landmarks=files.get("landmarks"),
        mouth=read_measures(files["mouth"], controls) if "mouth" in files else None,
        accents=files.get("accents"),
        tongue=files.get("tongue"),
        articulated=bool(document.get("articulated", False)),
    )


def _poses(document: dict[str, Any], controls: tuple[str, ...], rest: Array) -> tuple[Array, Array]:
    """The mean pose and the eight, (controls,) and (8, controls); controls that a pose omits are at rest."""
    written = document.get("poses", {})
    if not written:
        return rest, np.zeros((0, len(controls)))
    table = np.tile(rest, (1 + len(POSES), 1))
    for row, pose in enumerate((MEAN, *POSES)):
        for name, value in written.get(pose, {}).items():
            table[row, controls.index(name)] = value
    return table[0], table[1:]


def _through(
    document: dict[str, Any], path: Path, controls: tuple[str, ...], chain: tuple[Path, ...]
) -> Through | None:
    if "through" not in document:
        return None
    if "table" not in document:
        raise RigError(f'{path}: goes through {document["through"]!r} and so needs a table = "FILE.csv"')
    rig = _load(document["through"], chain)
    table = read_mixture(path.parent / document["table"], rig.controls, controls)
    shares = document.get("shares", {})
    parts = [(controls.index(own), *_share(path, own, share, rig.controls)) for own, share in shares.items()]
    return Through(rig, table, tuple(parts))


def _share(path: Path, own: str, share: str, others: tuple[str, ...]) -> tuple[int, int]:
    part, _, whole = (name.strip() for name in str(share).partition("/"))
    for name in (part, whole):
        if name not in others:
            raise RigError(
                f"{path}: [shares] {own} = {share!r}: the rig it goes through has no {name!r}"
                f'{_hint(name, others)}; write "a / b"'
            )
    return others.index(part), others.index(whole)


def _visemes(document: dict[str, Any], files: dict[str, Path], controls: tuple[str, ...]) -> Visemes | None:
    if "visemes" not in files:
        return None
    stepped = bool(document.get("stepped", False))
    if not stepped and "shapes" not in files:
        raise RigError(f'{files["visemes"]}: its rig needs shapes = "FILE.csv", or stepped = true')
    shapes = np.zeros((len(controls), 0)) if stepped else read_shapes(files["shapes"], controls)
    return Visemes(read_visemes(files["visemes"], controls), stepped, shapes)
