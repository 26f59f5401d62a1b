"""Results as they show themselves: in a terminal and as cards in a notebook, one screen each."""

from __future__ import annotations

import dataclasses
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from small_collection import QUICK, poses

import qgeo_filters as qg
from qgeo_filters.html_repr import MOST_ROWS, card, histogram, shown, span
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.testing import sample_surface

SURFACE = sample_surface()
N = SURFACE.n_vertices
NAME = '<b>Tom & "Jerry"</b>'


class Reader(HTMLParser):
    """Tags that are open, all that were seen, and the text."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)
        self.seen.append((tag, dict(attrs)))

    def handle_startendtag(self, tag: str, attrs: Any) -> None:
        self.seen.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data + "\n"


def read(html: str) -> Reader:
    reader = Reader()
    reader.feed(html)
    reader.close()
    assert reader.open == []
    return reader


@pytest.fixture(scope="module")
def found() -> tuple[qg.MatchResult, qg.MatchLog]:
    other = SURFACE.with_vertices(2 * SURFACE.vertices)
    return qg.match(SURFACE, other, landmarks=[(3, 3)], log=True)


def mirrored() -> qg.Surface:
    ball = SURFACE.vertices / [1.4, 1, 0.8]
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    return SURFACE.with_vertices(ball * [1, 1.6, 0.7] * (1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]))


@pytest.fixture(scope="module")
def results(found: tuple[qg.MatchResult, qg.MatchLog]) -> dict[str, Any]:
    """One of every kind of result."""
    bent = SURFACE.with_vertices(SURFACE.vertices * [1.1, 1.0, 0.9])
    spectrum = qg.distance_spectrum(SURFACE, 20)
    both = qg.Surface(
        np.concatenate([SURFACE.vertices, SURFACE.vertices / 2 + 9]), np.r_[SURFACE.faces, SURFACE.faces + N]
    )
    doubled = SURFACE.vertices, np.concatenate([SURFACE.faces, SURFACE.faces[:1]])
    return {
        "MatchResult": found[0],
        "MatchLog": found[1],
        "PiecewiseMatch": qg.match_pieces(both, both),
        "Symmetry": qg.self_symmetry(mirrored()),
        "Symmetry, none": qg.self_symmetry(SURFACE),
        "Compatibility": qg.compatibility([SURFACE, bent, SURFACE], k=8),
        "CommutativeSpectra": qg.commutative_eigenspectra(spectrum, spectrum, np.arange(N)),
        "Spectrum": spectrum,
        "Spectrum, streamed": qg.streamed_spectrum(SURFACE, 5, landmarks=20),
        "LiftedMetric": qg.lifted_metric(SURFACE),
        "PrincipalCurvatures": qg.principal_curvatures(SURFACE),
        "GeodesicPath": qg.quasi_geodesic(SURFACE, 0, 50),
        "GeodesicPath, nowhere": qg.quasi_geodesic(SURFACE, 3, 3),
        "Repair": qg.repair_surface(doubled),
        "Repair, nothing": qg.repair_surface(SURFACE),
        "Animation": qg.interpolate(SURFACE, bent, [0, 0.5, 1]),
        "Transfer": qg.transfer_deformation(SURFACE, [bent], SURFACE, np.arange(N)),
        "Surface": SURFACE.with_attributes({NAME: np.zeros((N, 3)), "height": np.zeros(N)}),
        "Landmarks": Landmarks(names=[NAME, "b"], vertices=np.array([3, -1])),
    }


def test_each_result_is_one_screen_in_a_terminal(results: dict[str, Any]) -> None:
    for name, result in results.items():
        lines = repr(result).splitlines()
        assert lines[0].startswith(name.partition(",")[0]), name
        assert len(lines) <= 12, name
        assert max(map(len, lines)) <= 240, name
        assert "array(" not in repr(result), name


def test_each_result_is_one_screen_in_a_notebook(results: dict[str, Any]) -> None:
    for name, result in results.items():
        html = result._repr_html_()
        reader = read(html)
        assert reader.text.startswith(name.partition(",")[0]), name
        assert len(html) < 16_000, name
        rows = sum(tag == "tr" for tag, _ in reader.seen)
        assert 1 <= rows <= MOST_ROWS + 12 or "MatchLog" in name, name
        assert not {tag for tag, _ in reader.seen} & {"script", "style", "link", "img", "b"}, name
        assert not re.search(r"https?:", html), name
        for tag, attributes in reader.seen:  # the page has the colours: its theme may be light or dark
            style = attributes.get("style") or ""
            assert "#" not in style, (name, tag)
            assert not re.search(r"(?<!-)color:(?!inherit)", style), (name, tag)
            assert not re.search(r"background:(?!none)", style), (name, tag)


def test_every_public_result_has_a_card_and_a_short_repr() -> None:
    """The package's dataclasses that hold arrays: without one of their own they would print them all."""
    lacking = []
    for name in qg.__all__:
        value = getattr(qg, name)
        if (
            isinstance(value, type)
            and dataclasses.is_dataclass(value)
            and name not in ("MatchingParameters", "BarycentricMap")
        ):
            lacking += [name] if not hasattr(value, "_repr_html_") else []
            assert value.__repr__.__qualname__ != "__create_fn__.<locals>.__repr__", name
    assert lacking == []


def test_a_match_says_whether_it_is_sure(found: tuple[qg.MatchResult, qg.MatchLog]) -> None:
    result, log = found
    text = read(result._repr_html_()).text
    assert f"confident: {result.explanation}" in text
    assert f"{shown(result.score)} sqrt(area)" in text
    assert "landmarks missed by" in text
    unsure = dataclasses.replace(result, confident=False, explanation="<two> maps & no more")
    assert "NOT CONFIDENT: <two> maps & no more" in read(unsure._repr_html_()).text
    assert "chosen" in read(log._repr_html_()).text


def test_a_symmetry_says_what_was_found(results: dict[str, Any]) -> None:
    symmetry, none = results["Symmetry"], results["Symmetry, none"]
    assert f"{int((symmetry.side == 1).sum())} and {int((symmetry.side == -1).sum())}" in repr(symmetry)
    assert symmetry.reason in repr(symmetry)
    assert "in a plane to" in repr(symmetry)
    assert none.reason in repr(none)
    assert f"NONE FOUND: {none.reason}" in read(none._repr_html_()).text


def test_compatibility_has_its_table(results: dict[str, Any]) -> None:
    found = results["Compatibility"]
    text = read(found._repr_html_()).text
    for value in found.c_xy[np.triu_indices(3, 1)]:
        assert shown(float(value)) in text
    assert f"D(S) = {found.d_s:.4g}" in repr(found)


def test_a_collection_names_its_shapes(tmp_path) -> None:
    pytest.importorskip("zarr")
    collection = qg.Collection(poses(3), tmp_path / "poses.zarr", parameters=QUICK)
    text = read(collection._repr_html_()).text
    assert f"Collection of {len(collection)} shapes" in text
    assert collection.names[0] in text


def test_everything_that_is_given_is_escaped() -> None:
    html = card(
        NAME, {NAME: NAME}, subtitle=NAME, table=[(NAME, NAME)], columns=(NAME, NAME), bars=[1, 2], bars_label=NAME
    )
    reader = read(html)
    assert "<b>" not in html
    assert reader.text.count(NAME) == 9
    (picture,) = (attributes for tag, attributes in reader.seen if tag == "svg")
    assert picture["aria-label"] == NAME


def test_long_tables_and_values_are_cut() -> None:
    reader = read(
        card("Many", {"text": "x" * 1000, "list": list(range(50)), "none": None}, table=[(str(k),) for k in range(40)])
    )
    assert sum(tag == "tr" for tag, _ in reader.seen) == 2 + MOST_ROWS
    assert f"the first {MOST_ROWS} of 40" in reader.text
    assert "0, 1, 2, 3, 4, 5, 6, 7, ... (50)" in reader.text
    assert "x" * 300 not in reader.text
    assert "none" not in reader.text


def test_bars_are_the_heights_and_empty_ones_are_none() -> None:
    heights = histogram([0.0, 1.0, 1.0, np.nan, np.inf], [1, 2, 3, 100, 100])
    assert (heights.sum(), heights[0], heights[-1]) == (6, 1, 5)
    reader = read(card("", {}, bars=[0.0, 2.0, 4.0]))
    assert [attributes["height"] for tag, attributes in reader.seen if tag == "rect"] == ["1.0", "16.0", "31.0"]
    for bars in ([], [0.0], [np.nan]):
        assert "svg" not in card("", {}, bars=bars)


def test_values_as_text() -> None:
    assert [shown(value) for value in (True, np.bool_(False), 0.123456, np.float64(2), 7, "a")] == [
        "yes", "no", "0.1235", "2", "7", "a",
    ]  # fmt: skip
    assert [shown(value) for value in (19584.7, 1234.56, 1.5e9)] == ["19585", "1235", "1.5e+09"]
    assert span([3.0, np.nan, 1.0]) == "1 to 3"
    assert span([np.nan]) == "none"
