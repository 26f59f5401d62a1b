"""The report in a browser: by night its pictures have the colours that they have by day; on paper."""

from __future__ import annotations

import re
from pathlib import Path

import browser as tools
import numpy as np
import pytest
from matplotlib.figure import Figure

from qgeo_filters.report.html import Meaning, Picture, Table, write_report

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


@pytest.mark.parametrize("width", [390, 1280])
def test_rows_of_several_meshes_keep_their_columns(chromium, tmp_path: Path, width: int) -> None:  # type: ignore[no-untyped-def]
    """On a narrow page, too, values of both meshes stand below their names, and what a number means under its row."""
    counts = [("vertices", 2504, 2511, Meaning("points")), ("boundary_loops", 0, 1, Meaning("holes and rims " * 6))]
    tables = [Table("Meshes", counts, ["", "horse0.off", "horse6.off", ""])]
    write_report(tmp_path / "report.html", "Two meshes", tables=tables)
    page = chromium.new_page(viewport={"width": width, "height": 800})
    page.goto((tmp_path / "report.html").as_uri())
    rows = page.evaluate(
        """() => [...document.querySelectorAll('tr')].map(row => [...row.children].map(cell => {
            const box = cell.getBoundingClientRect(); return [box.left, box.top, box.right, box.bottom];
        }))"""
    )
    _, *names = np.array(rows[0])[:3]
    for row in np.array(rows[1:]):
        for name, value in zip(names, row[1:3], strict=True):
            assert abs(value[0] - name[0]) < 2
            assert value[1] >= name[3] - 1
        assert abs(row[:3, 1] - row[0, 1]).max() < 1
        assert row[3, 2] <= width
        assert (row[3, 1] >= row[:3, 3].max() - 1) == (width == 390)
    page.close()


def test_files_and_what_they_hold_fit_a_narrow_page(chromium, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """Nothing of the table lies beyond its edge, where one would have to scroll to it."""
    files = {"horse0_on_horse6.ply": "X deformed onto Y, its triangles and colours, as MeshLab and Blender show it"}
    write_report(tmp_path / "report.html", "Files", tables=[Table.of("Files", files)])
    page = chromium.new_page(viewport={"width": 390, "height": 800})
    page.goto((tmp_path / "report.html").as_uri())
    assert (
        page.evaluate("(() => { const e = document.querySelector('.scroll'); return e.scrollWidth - e.clientWidth })()")
        == 0
    )
    assert page.evaluate("document.querySelector('.sentence').getBoundingClientRect().width") > 150
    page.close()
