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


def alike(value: Any) -> st.SearchStrategy[Any]:
    """Values of the same type, which a reader that looks at types alone would take."""
    if isinstance(value, bool):
        return st.booleans()
    if isinstance(value, (int, float)):
        return st.sampled_from([0, 1, -value, 2 * value, value // 2, 0.1, 1e-300, 1e6]) | NUMBERS
    if isinstance(value, str):
        return st.sampled_from([f"{value}x", value.upper(), f" {value}", f"{value}\u0301"]) | TEXTS
    if isinstance(value, list):
        return st.sampled_from([value[::-1], value[:-1], value + value[:1], value * 3, []])
    if isinstance(value, dict):
        others = {**value, "extra": 1}, dict(reversed(value.items()))
        return st.sampled_from([*others, dict(list(value.items())[:-1])])
    return st.none()


@st.composite
def damaged(draw: st.DrawFn, tree: Any, values: st.SearchStrategy[Any] = VALUES) -> Any:
    """The tree with one to three values removed, or replaced: mostly by others of the same type."""
    tree = copy.deepcopy(tree)
    for _ in range(draw(st.sampled_from([1, 1, 2, 3]))):
        known = places(tree)
        if not known:
            return tree
        *above, last = draw(st.sampled_from(known))
        at = tree
        for key in above:
            at = at[key]
        how = draw(st.sampled_from(["alike", "alike", "alike", "other", "gone"]))
        if how == "gone" and isinstance(at, dict):
            del at[last]
        else:
            at[last] = draw(values if how == "other" else alike(at[last]))
    return tree
