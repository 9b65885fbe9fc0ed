"""Hypothesis strategies for files that nobody means: a sound tree with values replaced, at any place."""

from __future__ import annotations

import copy
from typing import Any

from hypothesis import strategies as st

NUMBERS = st.one_of(
    st.sampled_from([-1, 0, 10**10, 10**400, 1e300, -1e300, 3e38, 0.5]), st.integers(), st.floats()
)
TEXTS = st.one_of(
    st.sampled_from(["", "../victim", "http://127.0.0.1/a", "a\0b", "\ud800", "x" * 300]), st.text()
)
LEAVES = st.one_of(NUMBERS, TEXTS, st.none(), st.booleans())
VALUES = st.recursive(
    LEAVES, lambda c: st.lists(c, max_size=3) | st.dictionaries(TEXTS, c, max_size=3), max_leaves=5
)


def places(tree: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The keys that lead to every value of a tree; of long lists, to the first three items."""
    items = list(tree.items()) if isinstance(tree, dict) else list(enumerate(tree[:3]))
    found = []
    for key, value in items:
        found.append((*above, key))
        if isinstance(value, (dict, list)):
            found += places(value, (*above, key))
    return found


@st.composite
def damaged(draw: st.DrawFn, tree: Any, values: st.SearchStrategy[Any] = VALUES) -> Any:
    """The tree with one to three values replaced or removed."""
    tree = copy.deepcopy(tree)
    for _ in range(draw(st.integers(1, 3))):
        known = places(tree)
        if not known:
            return tree
        *above, last = draw(st.sampled_from(known))
        at = tree
        for key in above:
            at = at[key]
        if draw(st.booleans()) and isinstance(at, dict):
            del at[last]
        else:
            at[last] = draw(values)
    return tree
