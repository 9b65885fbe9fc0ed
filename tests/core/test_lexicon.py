import os

from phonanim.core import lexicon


def test_tables_of_a_folder_that_changes(tmp_path, monkeypatch):
    monkeypatch.setenv("PHONANIM_PATH", str(tmp_path))
    folder = tmp_path / "languages"
    assert "mine" not in lexicon.find_tables("languages")
    folder.mkdir()
    for number, name in enumerate(("mine", "yours")):
        (folder / f"{name}.toml").write_text("")
        assert lexicon.find_tables("languages")[name] == folder / f"{name}.toml"
        os.utime(folder, (number, number))  # long ago, so that the list is kept
        assert name in lexicon.find_tables("languages")
    (folder / "mine.toml").unlink()
    assert "mine" not in lexicon.find_tables("languages")
    assert "english" in lexicon.find_tables("languages")


def test_the_tables_are_sorted(monkeypatch):
    monkeypatch.delenv("PHONANIM_PATH", raising=False)
    names = list(lexicon.find_tables("rigs"))
    assert names == sorted(names)
    assert "arkit" in names
