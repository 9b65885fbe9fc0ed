import ast
import re
import runpy
import sys

import pytest

import phonanim

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@pytest.fixture(scope="module")
def config(root):
    return tomllib.loads((root / "pyproject.toml").read_text("utf-8"))


def test_listed_packages_are_the_folders_on_disk(root, config):
    folders = {
        ".".join(path.parent.relative_to(root).parts) for path in (root / "phonanim").rglob("__init__.py")
    }
    assert set(config["tool"]["setuptools"]["packages"]) == folders | {"phonanim.lexicon"}


def test_the_version_is_the_top_of_the_changelog(root):
    versions = re.findall(r"^## (\S+)", (root / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert next(name for name in versions if name != "Unreleased") == phonanim.__version__


def test_every_file_names_one_version(root):
    release = runpy.run_path(str(root / "scripts/check_release.py"))
    assert set(release["find_versions"]().values()) == {phonanim.__version__}


def test_every_extra_that_errors_name_exists(root, config):
    named = set()
    for path in (root / "phonanim").rglob("*.py"):
        named |= set(re.findall(r"phonanim\[(\w+)\]", path.read_text("utf-8")))
    assert named
    assert named <= set(config["project"]["optional-dependencies"])


def imports(path):
    """The top-level names of every module that a file imports, at any place in it."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module.partition(".")[0]


def names(requirements):
    return {re.match(r"[\w-]+", line)[0].replace("-", "_") for line in requirements}


def test_what_is_depended_on_is_imported_and_the_other_way_round(root, config):
    core = names(config["project"]["dependencies"])
    extras = names(line for lines in config["project"]["optional-dependencies"].values() for line in lines)
    imported = {name for path in (root / "phonanim").rglob("*.py") for name in imports(path)}
    others = imported - set(sys.stdlib_module_names) - {"phonanim", "tomllib"}
    modules = {
        "sklearn": "scikit_learn",
        "PIL": "pillow",
        "pxr": "usd_core",
        "pythonosc": "python_osc",
        "parselmouth": "praat_parselmouth",
        "yaml": "pyyaml",
        "pyopenjtalk": "pyopenjtalk_plus",
    }
    assert core <= imported
    assert {modules.get(name, name) for name in others} <= core | extras


def test_every_dependency_has_a_lowest_version(root, config):
    lowest_versions = runpy.run_path(str(root / "scripts/lowest_versions.py"))["lowest_versions"]
    declared = config["project"]["dependencies"]
    assert [line.replace("==", ">=", 1) for line in lowest_versions(declared)] == declared
    assert lowest_versions(['a-b>=1.2; python_version < "3.11"']) == ['a-b==1.2; python_version < "3.11"']
    with pytest.raises(ValueError, match="'numpy' has no lowest version; write name>=version"):
        lowest_versions(["numpy"])
