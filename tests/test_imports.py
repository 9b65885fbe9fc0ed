"""How modules import each other, and what animating loads."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

LARGE = ("torch", "sklearn", "scipy", "matplotlib")


def module_name(path: Path, root: Path) -> str:
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def imported(tree: ast.AST, modules: set[str]) -> Iterator[str]:
    """The modules among `modules` that a file imports at any place in it, also for types alone."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            parts = (f"{node.module}.{alias.name}" for alias in node.names)
            yield from (part if part in modules else node.module for part in parts)


def import_graph(root: Path, package: str) -> dict[str, set[str]]:
    paths = {module_name(path, root): path for path in (root / package).rglob("*.py")}
    trees = {name: ast.parse(path.read_text("utf-8")) for name, path in paths.items()}
    return {name: set(imported(tree, set(paths))) - {name} for name, tree in trees.items()}


def test_no_modules_import_each_other_in_a_circle(root):
    graph = import_graph(root, "phonanim")
    assert "phonanim.speech.phones" in graph["phonanim.pipeline"]
    list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the modules


def test_a_circle_is_found_in_functions_and_types_too(tmp_path):
    folder = tmp_path / "made"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "one.py").write_text("def run():\n    from made import two\n")
    (folder / "two.py").write_text("if TYPE_CHECKING:\n    from made.one import run\n")
    with pytest.raises(CycleError, match="made.one"):
        list(TopologicalSorter(import_graph(tmp_path, "made")).static_order())


def test_animating_loads_no_large_library(root, tmp_path):
    script = (
        "import sys\n"
        "from phonanim.__main__ import main\n"
        "try:\n"
        "    main()\n"
        "finally:\n"
        f"    print('loaded', [name for name in {LARGE!r} if name in sys.modules])\n"
    )
    line = root / "examples" / "line.TextGrid"
    outputs = [arg for suffix in ("glb", "csv", "html") for arg in ("-o", str(tmp_path / f"line.{suffix}"))]
    done = subprocess.run(
        [sys.executable, "-c", script, "animate", str(line), *outputs],
        cwd=root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "loaded []"
    assert (tmp_path / "line.glb").stat().st_size > 0
