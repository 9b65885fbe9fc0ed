from pathlib import Path

from phonanim.core.clone import add_clone_hint, clone_folder


def test_an_extra_is_named_as_a_clone_has_it(root):
    assert clone_folder() == root.resolve()
    said = add_clone_hint("a.usdc: needs pip install 'phonanim[usd]'", Path("/src/phonanim"))
    assert said.endswith("pip install 'phonanim[usd]' (from a clone: pip install '.[usd]' in /src/phonanim)")
    assert "'.[video,train]'" in add_clone_hint("pip install 'phonanim[video,train]'", Path("/src"))


def test_other_messages_and_installed_packages_stay_as_they_are():
    assert add_clone_hint("pip install 'phonanim[usd]'", None) == "pip install 'phonanim[usd]'"
    assert add_clone_hint("a.csv: cannot be read", Path("/src")) == "a.csv: cannot be read"
