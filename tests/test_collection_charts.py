"""Pictures of tables of distances: what they show is read back from the figures."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

import qgeo_filters as qg
from qgeo_filters.report.collection_charts import embedding, plot_dendrogram, plot_embedding, plot_heat_map

NAMES = [f"{group}{i}" for group in ("cat", "dog", "horse") for i in range(4)]
GROUPS = {name: name[:-1] for name in NAMES}
rng = np.random.default_rng(0)
PLACES = np.repeat([[0, 0], [6, 0], [0, 9]], 4, axis=0) + rng.uniform(-1, 1, (12, 2))
ORDER = rng.permutation(12)
SQUARE = np.linalg.norm(PLACES[:, None] - PLACES[None], axis=2)
TABLE = pd.DataFrame(SQUARE, NAMES, NAMES).iloc[ORDER, ORDER]


def labels(texts) -> list[str]:
    return [text.get_text() for text in texts]


def test_groups_stand_together_in_the_tree_and_have_one_colour():
    figure = plot_dendrogram(TABLE, GROUPS)
    axes = figure.axes[0]
    texts = axes.get_yticklabels()
    groups = [GROUPS[name] for name in labels(texts)]
    assert sum(a != b for a, b in pairwise(groups)) == 2
    colours = {(GROUPS[text.get_text()], str(text.get_color())) for text in texts}
    assert len(colours) == 3
    assert sorted(labels(figure.legends[0].get_texts())) == ["cat", "dog", "horse"]


def test_points_of_the_plane_are_found_again():
    places, stress = embedding(SQUARE)
    assert np.linalg.norm(places[:, None] - places[None], axis=2) == pytest.approx(SQUARE, abs=1e-3)
    assert stress < 1e-4
    again, _ = embedding(SQUARE)
    assert np.array_equal(places, again)


def test_the_embedding_says_its_stress_and_names_each_point():
    figure = plot_embedding(np.ones((5, 5)) - np.eye(5))
    assert sorted(labels(figure.axes[0].texts)) == ["0", "1", "2", "3", "4"]
    assert "stress 0.2" in figure.axes[0].get_xlabel()  # five points as far from each other as from all others
    figure = plot_embedding(TABLE, GROUPS, labelled=False)
    assert len(figure.axes[0].collections) == 3
    assert not figure.axes[0].texts


def test_the_heat_map_is_the_table_in_the_order_of_its_labels():
    table = TABLE.copy()
    table.loc["cat0", "dog1"] = table.loc["dog1", "cat0"] = np.nan
    axes = plot_heat_map(table, GROUPS, label="C").axes[0]
    order = labels(axes.get_yticklabels())
    assert labels(axes.get_xticklabels()) == order
    groups = [GROUPS[name] for name in order]
    assert sum(a != b for a, b in pairwise(groups)) == 2
    shown = axes.images[0].get_array()
    assert np.array_equal(np.ma.filled(shown, np.nan), table.loc[order, order].to_numpy(), equal_nan=True)
    assert np.array_equal(~axes.images[1].get_array().mask, np.eye(12, dtype=bool))  # white, and nothing else is
    plain = plot_heat_map(table, ordered=False).axes[0]
    assert labels(plain.get_xticklabels()) == list(table.index)


@pytest.mark.parametrize("draw", [plot_dendrogram, plot_embedding, plot_heat_map])
def test_what_cannot_be_drawn_is_told(draw):
    with pytest.raises(qg.ParameterError, match="must be square"):
        draw(np.zeros((3, 2)))
    with pytest.raises(qg.ParameterError, match="at least two"):
        draw(np.zeros((1, 1)))
    with pytest.raises(qg.ParameterError, match="which is negative"):
        draw(-SQUARE)
    with pytest.raises(qg.ParameterError, match=r"no group of .*\(11 such"):
        draw(TABLE, {"cat0": 1})
    with pytest.raises(qg.ParameterError, match="2 groups for 12"):
        draw(TABLE, [1, 2])
    with pytest.raises(qg.ParameterError, match="same order"):
        draw(TABLE[NAMES])
    if draw is not plot_heat_map:
        with pytest.raises(qg.ParameterError, match=r"0 and 1 is not known \(2 such\)"):
            draw(np.where(np.arange(2)[:, None] == np.arange(2), 0, np.nan))
        with pytest.raises(qg.ParameterError, match="not symmetric"):
            draw(np.triu(SQUARE))


def test_the_table_is_not_changed():
    before = TABLE.copy()
    for draw in (plot_dendrogram, plot_embedding, plot_heat_map):
        draw(TABLE, GROUPS)
    assert TABLE.equals(before)
