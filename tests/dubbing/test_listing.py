"""Whether files exist, by the names that their folders have."""

import unicodedata

from phonanim.dubbing.listing import first_listed, folded_name, forget_folders


def test_the_first_suffix_that_is_there(tmp_path):
    for name in ("a.flac", "a.WAV", "sub/b.wav"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    forget_folders()
    assert first_listed(f"{tmp_path}/a", (".wav", ".WAV", ".flac")) == tmp_path / "a.WAV"
    assert first_listed(f"{tmp_path}/sub/b", (".wav",)) == tmp_path / "sub/b.wav"
    assert first_listed(f"{tmp_path}/sub", ("",)) is None  # a folder is no file
    assert first_listed(f"{tmp_path}/none/a", (".wav",)) is None


def test_names_that_compose_differently_are_asked_for(tmp_path):
    (tmp_path / "é.wav").touch()
    forget_folders()
    found = first_listed(f"{tmp_path}/{unicodedata.normalize('NFD', 'é')}", (".wav",))
    assert found is None or found.is_file()  # as the file system has it
    assert folded_name(unicodedata.normalize("NFD", "É.WAV")) == folded_name("é.wav")


def test_a_new_file_is_found_once_the_names_are_forgotten(tmp_path):
    forget_folders()
    assert first_listed(f"{tmp_path}/a", (".wav",)) is None
    (tmp_path / "a.wav").touch()
    assert first_listed(f"{tmp_path}/a", (".wav",)) is None
    forget_folders()
    assert first_listed(f"{tmp_path}/a", (".wav",)) == tmp_path / "a.wav"
