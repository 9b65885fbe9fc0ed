import re
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
    assert versions[0] == phonanim.__version__


def test_every_extra_that_errors_name_exists(root, config):
    named = set()
    for path in (root / "phonanim").rglob("*.py"):
        named |= set(re.findall(r"phonanim\[(\w+)\]", path.read_text("utf-8")))
    assert named
    assert named <= set(config["project"]["optional-dependencies"])
