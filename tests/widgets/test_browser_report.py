"""The report in a browser: by night its pictures have the colours that they have by day; on paper."""

from __future__ import annotations

import re
from pathlib import Path

import browser as tools
import numpy as np
import pytest
from matplotlib.figure import Figure

from qgeo_filters.report.html import Picture, Table, write_report

pytestmark = [pytest.mark.browser, pytest.mark.slow]


def test_pictures_are_not_dimmed_in_the_dark(chromium, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """Two colours of a scale, and the white of the paper, come out to the bit; what lies around them is dark."""
    figure = Figure(figsize=(4, 2), dpi=100, facecolor="white")
    axes = figure.add_axes((0.25, 0.25, 0.5, 0.5))
    axes.imshow([[0.2, 0.9]], cmap="viridis", vmin=0, vmax=1, aspect="auto")
    axes.set_axis_off()
    write_report(tmp_path / "report.html", "Colours", pictures=[Picture("colours", figure, "Two colours.")])
    found = {}
    for scheme in ("light", "dark"):
        page = chromium.new_page(viewport={"width": 900, "height": 700}, color_scheme=scheme)
        page.goto((tmp_path / "report.html").as_uri())
        image = page.locator("figure img")
        image.evaluate("image => image.decode()")
        shown = tools.pixels(image)
        height, width = shown.shape[:2]
        found[scheme] = [shown[height // 2, round(share * width)] for share in (0.38, 0.62, 0.08)]
        body = tools.pixels(page.locator("body"))[2, 2]
        assert (body.mean() > 200) == (scheme == "light")
        page.close()
    np.testing.assert_array_equal(found["dark"], found["light"])
    assert (found["dark"][2] == 255).all()
    assert np.ptp(found["dark"][:2], axis=0).max() > 50


def test_a_dark_page_is_printed_black_on_white(chromium, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """With the colours of paper, within the sheet, without pages that are left half empty before a long table."""
    rows = {f"a_number_with_a_long_name_{k}": "distances are kept to 0.010 sqrt(area) in the mean" for k in range(17)}
    tables = [Table.of(f"Table {k}", rows) for k in range(5)]
    figure = Figure(figsize=(8, 5), dpi=100)
    picture = Picture("some", figure, "A picture.")
    write_report(tmp_path / "report.html", "On paper", pictures=[picture], tables=tables)
    page = chromium.new_page(viewport={"width": 688, "height": 1000}, color_scheme="dark")
    page.goto((tmp_path / "report.html").as_uri())
    page.emulate_media(media="print", color_scheme="dark")
    colors = page.evaluate(
        """() => ['body', '.table', 'figure', 'td', 'th', 'h1', 'h2'].map(name => {
            const style = getComputedStyle(document.querySelector(name));
            return [style.color, style.backgroundColor];
        })"""
    )
    assert {text for text, _ in colors} == {"rgb(0, 0, 0)"}
    assert {ground for _, ground in colors} <= {"rgb(255, 255, 255)", "rgba(0, 0, 0, 0)"}
    assert page.evaluate("document.documentElement.scrollWidth") <= 688
    sheets = re.findall(rb"/Type\s*/Page\b", page.pdf(format="A4", prefer_css_page_size=True))
    filled = page.evaluate("document.documentElement.scrollHeight") / 1017  # A4 less 14 mm at each end
    assert len(sheets) < filled + 1.1
    page.close()
