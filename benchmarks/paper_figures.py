"""The paper's Figures 1, 5, 6 and 7 on TOSCA poses, with a figure for what each is to show, and ten maps to look at.

Made by ``python benchmarks/paper.py``. The pictures show TOSCA's shapes, which may not be redistributed.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from paper_maps import GIVEN, NOT_GIVEN, Method, mapped, paired
from paper_study import FUNCTIONS, GUIDED, SCALAR, Arrays, Claim, Part, Study
from scipy.spatial import cKDTree

from qgeo_filters.atomic import atomic_path
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.matching.compatibility import compatibility_of_spectra
from qgeo_filters.matching.maps.functional_map import nearest_neighbors
from qgeo_filters.matching.regions import eigenfunction_regions
from qgeo_filters.matching.symmetry_measure import Reading, symmetry_regions
from qgeo_filters.report.charts import plot_distance_matrix
from qgeo_filters.report.colors import ColorScale, distinct, diverging, position_colors, sequential
from qgeo_filters.report.figures import plot_eigenfunctions
from qgeo_filters.report.html import Table
from qgeo_filters.report.maps import view_alike
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface

BANDS, REGIONS = 8, 12
MAPS = 10
_LARGEST_ERROR = 0.1
_MOSTLY = 0.6  # share of the area from which a picture shows what it claims
_READINGS: tuple[Reading, ...] = ("printed", "absolute")
_SUMMED = (5, FUNCTIONS)  # eigenfunctions in eq. (3); the paper: at most 20
_SHOWN = (1, 2, 4)  # of the common eigenfunctions, after the first, which has one sign
_POSES = 4


def first_figure(study: Study) -> Part:
    """Figure 1: the descriptor matrix and its eigenfunctions, in the guided and in the Cartesian metric."""
    name = study.names(study.categories[0])[0]
    surface = study.surface(name)
    pictures = []
    for weight in (0.0, GUIDED):
        metric = lifted_metric(surface, SCALAR, weight)
        words = "the Cartesian metric" if weight == 0 else f"the metric guided by {SCALAR}, weight {weight:g}"
        caption = (
            f"Figure 1: the matrix of all distances of {name} in {words}; rows in an order in which neighbours are "
            "near on the surface."
        )
        pictures.append(_picture(study, f"figure1-{name}-matrix-{weight:g}", caption, _matrix, metric))
        caption = f"Figure 1: its first eigenfunctions ({name}, {words})."
        spectrum = study.spectrum(name, weight)
        pictures.append(
            _picture(study, f"figure1-{name}-functions-{weight:g}", caption, plot_eigenfunctions, surface, spectrum)
        )
    return Part("Figure 1: the descriptor and its eigenfunctions", pictures=pictures)


def fifth_figure(study: Study) -> Part:
    """Figure 5: regions of equal value of eq. (3), and the share of the area where mirror images are in one region."""
    names = [study.names(category)[0] for category in study.categories]
    settings = list(itertools.product(_READINGS, _SUMMED, study.gentle))
    shares: dict[tuple[Reading, int, float], list[float]] = {}
    pictures = []
    for reading, count, weight in settings:
        regions = {n: symmetry_regions(study.spectrum(n, weight), BANDS, k0=count, reading=reading) for n in names}
        here = shares[reading, count, weight] = [_symmetric_share(study, n, regions[n]) for n in names]
        if weight == GUIDED:
            caption = (
                f"Figure 5: {BANDS} regions of equal area by the {reading} sum of {count} eigenfunctions, eq. (3), "
                f"weight {weight:g}, from two sides; with the share of the area whose mirror image is in the same one."
            )
            pictures.append(
                _picture(
                    study,
                    f"figure5-{reading}-{count}-{weight:g}-{'-'.join(names)}",
                    caption,
                    _both_sides,
                    study,
                    names,
                    regions,
                    here,
                )
            )
    rows = [
        (f"{reading}, {count} functions, weight {weight:g}", *(f"{100 * share:.0f}" for share in here))
        for (reading, count, weight), here in shares.items()
    ]
    note = f"At random {100 / BANDS:.0f} %. Mirror images are vertices: at a border either side may be right."
    table = Table("Area whose mirror image is in the same region (%)", rows, ["sum of eq. (3)", *names], note)
    best = {r: max(float(np.mean(v)) for (reading, *_), v in shares.items() if reading == r) for r, *_ in settings}
    measured = "; ".join(f"at most {100 * share:.0f} % of the area in the mean, {r} sum" for r, share in best.items())
    verdict = "holds" if best["printed"] > _MOSTLY else "does not hold as printed"
    if best["printed"] <= _MOSTLY < best["absolute"]:
        verdict += "; holds with absolute values"
    claim = Claim("Figure 5: mirror images fall into one region", "a picture", measured, verdict)
    return Part("Figure 5: regions of self-symmetry", [claim], [table], pictures)


def sixth_figure(study: Study) -> Part:
    """Figure 6: regions of equal colour on two poses, along the maps of Table 3."""
    methods = Method(GUIDED, GIVEN), Method(GUIDED, NOT_GIVEN), Method()
    shares: dict[Method, list[float]] = {method: [] for method in methods}
    pictures = []
    for category in study.categories:
        x, y = study.pairs(category)[0]
        functions, _ = paired(study, x, y, methods[0])
        areas = study.surface(x).vertex_areas
        regions_x, _ = eigenfunction_regions(functions, functions, np.arange(len(areas)), areas, REGIONS)
        carried = {}
        for method in methods:
            if method.reading:
                back = nearest_neighbors(*paired(study, x, y, method)[::-1])
            else:
                back = _back(study, y, mapped(study, x, y, method)["p2p"])
            carried[method] = regions_x[back]
            equal = carried[method][study.truth(x, y)] == regions_x
            shares[method].append(float(areas @ equal / areas.sum()))
        caption = (
            f"Figure 6: regions of {x} in the space of its eigenfunctions, and their places on {y}: by the paper's "
            "nearest neighbours with and without the vertex order, and by match."
        )
        here = {method: values[-1] for method, values in shares.items()}
        pictures.append(
            _picture(study, f"figure6-{x}-{y}-{GUIDED:g}", caption, _regions, study, (x, y), regions_x, carried, here)
        )
    claims = []
    for method, label in zip(methods, (GIVEN, NOT_GIVEN, "match"), strict=True):
        low, mean = min(shares[method]), float(np.mean(shares[method]))
        claims.append(
            Claim(
                f"Figure 6: regions of equal colour correspond ({label})",
                "a picture",
                f"{100 * mean:.0f} % of the area has its true colour in the mean, {100 * low:.0f} % at worst "
                f"({len(shares[method])} pairs, {REGIONS} regions)",
                "holds"
                if low > _MOSTLY
                else ("holds for some pairs" if max(shares[method]) > _MOSTLY else "does not hold"),
            )
        )
    return Part("Figure 6: regions of equal colour", claims, pictures=pictures)


def seventh_figure(study: Study) -> Part:
    """Figure 7: the baselines' optimised eigenspectra carried to further poses."""
    pictures = []
    for category in study.categories[:3]:
        names = study.names(category, _POSES)
        for weight in (0.0, GUIDED):
            caption = (
                f"Figure 7: eigenfunctions of the baselines S1 and S2, paired by eq. (4), and those that they select "
                f"on further poses of {category}, weight {weight:g}."
            )
            pictures.append(
                _picture(study, f"figure7-{'-'.join(names)}-{weight:g}", caption, _carried, study, names, weight)
            )
    return Part("Figure 7: compatibility", pictures=pictures)


def ten_maps(study: Study) -> Part:
    """Maps found by `match`: colours carried over, and the error."""
    pictures = []
    for number in range(MAPS):
        category = study.categories[number % len(study.categories)]
        pairs = study.pairs(category)
        if number // len(study.categories) >= len(pairs):
            continue
        x, y = pairs[number // len(study.categories)]
        found = mapped(study, x, y, Method())
        sure = "confident" if found["confident"] else "not confident"
        caption = (
            f"{x} in the colours of {y} along the map found by match, and its error: mean "
            f"{found['direct'].mean():.4f} sqrt(area), {100 * (found['direct'] <= 0.05).mean():.0f} % within .05; "
            f"{sure}."
        )
        pictures.append(_picture(study, f"map-{x}-{y}", caption, _map, study, x, y, found))
    return Part("Maps with no initial map", pictures=pictures)


def _matrix(metric: LiftedMetric) -> Figure:
    return plot_distance_matrix(distance_matrix(metric.surface, metric), metric.surface)


def _both_sides(study: Study, names: list[str], regions: dict[str, np.ndarray], shares: list[float]) -> Figure:
    ramp = sequential(np.arange(BANDS))(np.arange(BANDS))
    panels = []
    for name, share in zip(names, shares, strict=True):
        surface = study.surface(name)
        view = _view(surface)
        options = {"labels": regions[name], "colors": ramp}
        panels += [
            Panel(surface, view, f"{name}: {100 * share:.0f} %", options),
            Panel(surface, view.turned(180.0), options=options),
        ]
    return panel_figure(panels, columns=4)


def _regions(
    study: Study,
    pair: tuple[str, str],
    regions: np.ndarray,
    carried: dict[Method, np.ndarray],
    shares: dict[Method, float],
) -> Figure:
    x, y = (study.surface(name) for name in pair)
    view = _view(x)
    other = view_alike(x, view, y, study.truth(*pair))
    colors = distinct(REGIONS)
    panels = [Panel(x, view, pair[0], {"labels": regions, "colors": colors})]
    for method, labels in carried.items():
        title = f"{method.reading or 'match'}: {100 * shares[method]:.0f} %"
        panels.append(Panel(y, other, title, {"labels": labels, "colors": colors}))
    return panel_figure(panels, columns=2)


def _carried(study: Study, names: list[str], weight: float) -> Figure:
    spectra = [study.spectrum(name, weight) for name in names]
    found = compatibility_of_spectra(spectra, [study.truth(names[0], name) for name in names], k=FUNCTIONS)
    columns = []
    for spectrum, index, signs in zip(spectra, found.index, found.signs, strict=True):
        columns.append((spectrum.eigenfunctions[:, index] * signs)[:, _SHOWN] * np.sqrt(spectrum.areas.sum()))
    scale = diverging(np.concatenate(columns))
    first = study.surface(names[0])
    view = _view(first)
    views = [view, *(view_alike(first, view, study.surface(n), study.truth(names[0], n)) for n in names[1:])]
    panels = []
    for row, k in enumerate(_SHOWN):
        for pose, name in enumerate(names):
            options = {"values": columns[pose][:, row], "scale": scale, "isolines": [0.0]}
            title = f"S{pose + 1}: {name}" if row == 0 else f"$\\phi_{{{found.index[pose, k] + 1}}}$"
            panels.append(Panel(study.surface(name), views[pose], title, options))
    label = r"$\phi_k\,\sqrt{A}$ (line: zero)"
    title = f"D(S) = {found.d_s:.2f}, C_XY of the baselines {found.c_xy[0, 1]:.2f}"
    return panel_figure(panels, columns=len(names), scale=scale, scale_label=label, title=title)


def _map(study: Study, x: str, y: str, found: Arrays) -> Figure:
    source, target = study.surface(x), study.surface(y)
    view = _view(source)
    other = view_alike(source, view, target, found["p2p"])
    colors = position_colors(target.vertices, other.axes)
    scale = ColorScale(sequential([0.0, 1.0], "magma_r").colormap, 0.0, _LARGEST_ERROR)
    panels = [
        Panel(source, view, x, {"colors": colors[found["p2p"]]}),
        Panel(target, other, y, {"colors": colors}),
        Panel(source, view, f"mean error {found['direct'].mean():.4f}", {"values": found["direct"], "scale": scale}),
    ]
    return panel_figure(panels, scale=scale, scale_label="geodesic error (√area)")


def _back(study: Study, y: str, p2p: np.ndarray) -> np.ndarray:
    """Vertex of X for each of Y: a vertex that is mapped to it, or to the nearest one that has any."""
    reached, first = np.unique(p2p, return_index=True)
    vertices = study.surface(y).vertices
    return first[cKDTree(vertices[reached]).query(vertices)[1]]


def _symmetric_share(study: Study, name: str, regions: np.ndarray) -> float:
    areas = study.surface(name).vertex_areas
    return float(areas @ (regions[study.mirror(name)] == regions) / areas.sum())


def _view(surface: Surface) -> View:
    return best_view(surface.vertices, surface.faces)


def _picture(study: Study, name: str, caption: str, draw: Callable[..., Figure], *arguments: object) -> tuple[str, str]:
    """Name and caption, once the file is there."""
    path = study.figures / f"{name}.png"
    if not path.exists():
        figure = draw(*arguments)
        with atomic_path(path) as temporary:
            figure.savefig(temporary, format="png", metadata={"Software": None})
    return name, caption
