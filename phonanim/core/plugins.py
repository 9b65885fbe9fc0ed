"""Alternatives found by name: the files of a folder, and the plugins of other packages.

A registry is a folder of the package, such as `phonanim/readers`. Each of its files is a built-in part,
and the file's stem is its name. An installed package adds a part by an entry point of the same group, such as
`phonanim.readers`. The entry point names an object with the attributes that a file of the folder has.

A built-in part is found without searching the installed packages, which takes about 0.1 s. So a plugin
cannot replace a built-in part: the built-in name wins.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from phonanim.errors import PluginError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

_loaded: dict[str, str] = {}  # top-level module of each plugin in use -> its description


@dataclass(frozen=True)
class Registry:
    """The parts of one kind: `package` is the folder, `needs` the attributes that every part has.

    `group` is the entry-point group; the default is the name of the package.
    """

    package: str
    needs: tuple[str, ...]
    group: str = ""

    def built_in(self) -> tuple[str, ...]:
        """The parts of the package: the stems of the folder's files, sorted."""
        return _stems(self.package)

    def plugins(self) -> tuple[str, ...]:
        """The parts of other packages, sorted. Raises PluginError when two packages share a name."""
        return tuple(sorted(set(_entries(self.group or self.package)) - set(self.built_in())))

    def names(self) -> tuple[str, ...]:
        """Every part: the built-in ones, then the plugins."""
        return self.built_in() + self.plugins()

    def search(self) -> Iterator[str]:
        """The names one by one; installed packages are searched only after the built-in names."""
        yield from self.built_in()
        yield from self.plugins()

    def find(self, name: str) -> Any:
        """The part with a name, or None. Raises PluginError when a plugin cannot be used."""
        if name in self.built_in():
            return import_module(f"{self.package}.{name}")
        if name in self.plugins():
            return _load(self.group or self.package, name, self.needs)
        return None

    def name_of(self, module: str) -> str:
        """The name of the part that a module implements; without a plugin, the last part of its own name."""
        package, _, stem = module.rpartition(".")
        if package != self.package:
            for name, entry in _entries(self.group or self.package).items():
                if entry.module == module:
                    return name
        return stem


@cache
def plugin_packages() -> tuple[str, ...]:
    """The installed packages that have plugins of any group, with their versions, sorted."""
    from importlib.metadata import distributions

    found = (package for package in distributions() if any(map(_is_plugin, package.entry_points)))
    return tuple(sorted({f"{package.name} {package.version}" for package in found}))


def describe_failure(error: BaseException) -> str | None:
    """A sentence that names the plugin in whose code an error arose; None when no plugin is involved."""
    plugin = find_culprit(error.__traceback__)
    return plugin and f"{plugin} failed: {type(error).__name__}: {error}; update or uninstall it"


def find_culprit(trace: TracebackType | None) -> str | None:
    """The plugin in whose code an error arose, described for messages; None when no plugin is involved."""
    found = None
    while trace:
        root = str(trace.tb_frame.f_globals.get("__name__", "")).partition(".")[0]
        found = _loaded.get(root, found)
        trace = trace.tb_next
    return found


@cache
def _stems(package: str) -> tuple[str, ...]:
    folder = Path(str(sys.modules[package].__file__)).parent
    return tuple(sorted(path.stem for path in folder.glob("[a-z]*.py")))


@cache
def _entries(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name."""
    from importlib.metadata import entry_points  # costs 80 ms, so only when a name is not built in

    found: dict[str, EntryPoint] = {}
    for entry in entry_points(group=group):
        twin = found.setdefault(entry.name, entry)
        if twin.value != entry.value:
            packages = " and ".join(sorted((_distribution(twin), _distribution(entry))))
            raise PluginError(
                f"two packages have a plugin {entry.name!r} of {group}: {packages}; uninstall one"
            )
    return found


@cache
def _load(group: str, name: str, needs: tuple[str, ...]) -> Any:
    entry = _entries(group)[name]
    described = f"plugin {name!r} of {group} (package {_distribution(entry)})"
    try:
        part = entry.load()
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise PluginError(
            f"{described}: cannot be loaded: {reason}; update or uninstall the package"
        ) from error
    missing = [attribute for attribute in needs if not hasattr(part, attribute)]
    if missing:
        raise PluginError(f"{described}: has no {missing[0]}; {group} needs {', '.join(needs)}")
    _loaded[entry.module.partition(".")[0]] = described
    return part


def _is_plugin(entry: EntryPoint) -> bool:
    return entry.group.startswith("phonanim.")


def _distribution(entry: EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.value
