"""Measuring many pairs in a good order."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import icosphere
from test_house import ARROWS, MODULES

from qgeo_filters.evaluation import runner
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.surface import Surface

names = st.sampled_from("abcde")


@given(st.lists(st.tuples(names, names), max_size=20))
def test_pairs_of_one_target_stand_together(pairs: list[tuple[str, str]]) -> None:
    ordered = runner.by_target(pairs)
    assert sorted(ordered) == sorted(pairs)
    targets = [target for target, _ in groupby(y for _, y in ordered)]
    assert targets == list(dict.fromkeys(y for _, y in pairs))
    for target in targets:
        assert [pair for pair in ordered if pair[1] == target] == [pair for pair in pairs if pair[1] == target]


def test_distances_of_a_target_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Surface] = []

    def counted(surface: Surface) -> np.ndarray:
        asked.append(surface)
        return distance_matrix(surface)

    monkeypatch.setattr(runner, "distance_matrix", counted)
    one, other = (Surface(size * icosphere(1)[0], icosphere(1)[1]) for size in (1, 2))
    ruler = runner.Ruler()
    found = [ruler(surface) for surface in (one, one, other, one)]
    assert asked == [one, other, one]
    np.testing.assert_allclose(found[2], 2 * found[0], rtol=1e-5)
    np.testing.assert_array_equal(found[3], found[0])


def test_kept_results_know_all_code_that_they_depend_on() -> None:
    """Whatever `match` and `self_symmetry` import, directly or not: a change there makes kept results old."""
    needed, waiting = set(), ["matching.correspondence", "matching.symmetry"]
    while waiting:
        module = waiting.pop()
        if module not in needed:
            needed.add(module)
            waiting += [arrow.imported for arrow in ARROWS if arrow.importer == module and not arrow.typing_only]
    root = Path(runner.__file__).parents[1]
    known = {".".join(file.relative_to(root).with_suffix("").parts) for file in runner.numeric_sources()}
    assert needed <= known
    assert len(needed) > 40
    assert not {name for name in known & set(MODULES) if name.startswith(("report", "cli"))}
