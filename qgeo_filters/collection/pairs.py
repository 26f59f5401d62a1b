"""Which pairs of a collection are matched, and how they are cut into the chunks that a worker takes at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

from qgeo_filters.errors import ParameterError
from qgeo_filters.validation import checked_count

#: Pairs as `Collection.match` takes them.
Pairs: TypeAlias = Literal["all", "within groups"] | Iterable[tuple[str, str]] | None

# Pairs that a worker takes at once: those of one target, which it restores once.
MOST = 8


def chosen_pairs(pairs: Pairs, names: Sequence[str], groups: Sequence[str]) -> list[tuple[str, str]]:
    """Pairs of names, each once: those that are given, or each two shapes, the earlier one first.

    Raises
    ------
    ParameterError
        An unknown word or name, or the same shape twice.
    """
    if pairs is None or pairs == "all":
        return list(itertools.combinations(names, 2))
    if pairs == "within groups":
        if not any(groups):
            raise ParameterError("the shapes have no groups: give groups= to the collection, or match all pairs")
        group = dict(zip(names, groups, strict=True))
        return [(x, y) for x, y in itertools.combinations(names, 2) if group[x] == group[y]]
    if isinstance(pairs, str):
        raise ParameterError(f"pairs must be 'all', 'within groups' or pairs of names, got {pairs!r}")
    known, found = set(names), []
    for number, pair in enumerate(pairs):
        if isinstance(pair, str) or len(pair) != 2:
            raise ParameterError(f"pairs[{number}] must be two names, got {pair!r}")
        for name in pair:
            if name not in known:
                raise ParameterError(f"pairs[{number}] has {name!r}, and no shape is called so")
        if pair[0] == pair[1]:
            raise ParameterError(f"pairs[{number}] is {pair[0]!r} with itself")
        found.append((pair[0], pair[1]))
    return list(dict.fromkeys(found))


def chunks_of_pairs(pairs: Iterable[tuple[str, str]]) -> list[list[tuple[str, str]]]:
    """Pairs in chunks of one target each, in an order that depends on the pairs alone."""
    by_target: dict[str, list[tuple[str, str]]] = {}
    for pair in pairs:
        by_target.setdefault(pair[1], []).append(pair)
    return [
        together[first : first + MOST] for together in by_target.values() for first in range(0, len(together), MOST)
    ]


def checked_part(part: tuple[int, int]) -> tuple[int, int]:
    """Which part of how many, from 1; raises `ParameterError` for what is none."""
    try:
        k, n = part
    except (TypeError, ValueError):
        raise ParameterError(f"part must be two numbers such as (3, 40), the third of forty, got {part!r}") from None
    n = checked_count(n, 1, None, "the number of parts")
    return checked_count(k, 1, n, "part", f"the number of parts, {n}"), n
