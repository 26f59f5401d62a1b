"""The widget of self-symmetry: mirror images, axis, sides, asymmetry, and the regions of eq. (3)."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np
import traitlets

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.defaults import EIGENPAIRS, SYMMETRY_K0
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.matching.mirror_curve import left_right_difference
from qgeo_filters.matching.symmetry_measure import symmetry_regions, symmetry_sum
from qgeo_filters.report.colors import mirror_colors
from qgeo_filters.validation import checked_index
from qgeo_widgets import controls
from qgeo_widgets.base import ShapeWidget
from qgeo_widgets.coloring import ATTRIBUTE, EIGENFUNCTION
from qgeo_widgets.contours import sign_changes
from qgeo_widgets.fields import ColorField, Field, ScalarField, number_field, region_field
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import placement_of
from qgeo_widgets.shape import Shape

MIRRORED = "mirror images in one colour"
SIDES = "sides"
ASYMMETRY = "asymmetry"
DIFFERENCE = "left-right difference"
REGIONS = "regions of eq. (3)"
SUM = "sum of eq. (3)"
_PICKED, _IMAGE, _AXIS = (0.86, 0.11, 0.16), (0.98, 0.70, 0.10), (0.1, 0.1, 0.12)
_BANDS = 7  # at most eight regions, as many as there are colours that stay apart
_VIEWS = ("one view", "the opposite view")
# As in `Symmetry.side`: which side is 1 has no meaning, so that none is called left or right.
_SIDE_NAMES = {1: "side A", 0: "on the axis", -1: "side B"}


class SymmetryWidget(ShapeWidget):
    """A shape and its self-symmetry, seen from two opposite sides; see `qgeo_widgets.symmetry`.

    Attributes
    ----------
    picked : int or None
        The vertex that was clicked; `image` is its mirror image.
    epsilon, k0 : float, int
        Of eq. (3): width of the regions, and number of eigenfunctions in the sum.
    """

    _page_title = "A shape and its self-symmetry"
    _takes_repair = True
    picked = traitlets.Int(None, allow_none=True)
    epsilon = traitlets.Float(1.0)
    k0 = traitlets.Int(SYMMETRY_K0, min=1, max=EIGENPAIRS)

    def __init__(
        self, mesh: Any, *, symmetry: Any, curvature_weight: float, repair: RepairOption, size: tuple[int, int]
    ) -> None:
        super().__init__()
        with self._guarded():
            with self._long.during("Repairing the shape"):
                shape = self._shape = Shape(mesh, "X", curvature_weight, repair=repair)
            self._symmetry = self._find() if symmetry is None else _checked(symmetry, shape)
            placement = placement_of(shape.surface, shape.measured)
            titles = [f"<b>shape</b>, {shape.surface.n_vertices} vertices", f"<b>{_VIEWS[1]}</b>"]
            viewer = new_viewer([shape.surface] * 2, [placement, placement.turned()], size, titles)
            self._modes = self._make_modes()
            with self._long.during("Finding eigenfunctions"):
                total = float(np.ptp(self._measured_sum))
            self.epsilon = total / _BANDS
            self._epsilon_slider = controls.number("ε", self.epsilon, total / 60, total, total / 200)
            self._k0_slider = controls.whole("k₀", self.k0, 1, min(EIGENPAIRS, shape.measured.n_vertices))
            traitlets.link((self, "epsilon"), (self._epsilon_slider, "value"))
            traitlets.link((self, "k0"), (self._k0_slider, "value"))
            viewer.on_pick(lambda _, vertex: self.set_trait("picked", vertex))
            mode = MIRRORED if self._symmetry.found else REGIONS
            self._assemble(
                viewer,
                _VIEWS,
                mode,
                beside=[self._epsilon_slider, self._k0_slider],
            )
            self._draw_axis()
            self.observe(lambda _: self._show_measure_controls(), "mode")
            self._show_measure_controls()
            self.observe(lambda _: self._show_picked(), "picked")
            self.observe(lambda _: self._measure_changed(), ["epsilon", "k0"])
            self._show_picked()
            if not self._symmetry.found:
                self.message = f"No self-symmetry: {self._symmetry.reason}. The regions of eq. (3) are shown."

    def _find(self) -> Any:
        self._long.announce()
        with self._long.during("Finding the self-symmetry", at_once=True):
            shape, asked = self._shape.to_match
            return stages.symmetry_of(shape, repair=asked)

    @property
    def image(self) -> int | None:
        """Mirror image of the picked vertex, None without one."""
        if self.picked is None or not self._symmetry.found:
            return None
        found = int(self._symmetry.p2p[self.picked])
        return found if found >= 0 else None

    # -- picking ------------------------------------------------------------------------------------

    @traitlets.validate("picked")
    def _valid_vertex(self, proposal: Any) -> int | None:
        vertex = proposal["value"]
        if vertex is not None and self._viewer is not None:
            checked_index(vertex, self._shape.surface.n_vertices, "picked")
        return vertex

    @traitlets.validate("epsilon")
    def _valid_epsilon(self, proposal: Any) -> float:
        epsilon = float(proposal["value"])
        if not 0 < epsilon < np.inf:
            raise ParameterError(f"epsilon must be a finite number above 0, got {epsilon!r}")
        return epsilon

    def _show_picked(self) -> None:
        if self._viewer is None:
            return
        vertices = self._shape.surface.vertices
        for pane in self._viewer.panes:
            pane.set_mark("picked", None if self.picked is None else vertices[self.picked], _PICKED)
            pane.set_mark("image", None if self.image is None else vertices[self.image], _IMAGE)
        if self.picked is None:
            self._info.value = controls.table([["Click a point to see its mirror image."]])
            return
        here = self.picked
        rows = [["vertex", str(here)]]
        if self.image is not None:
            side = int(self._symmetry.side[here])
            rows += [
                ["mirror image", str(self.image)],
                ["side", _SIDE_NAMES.get(side, str(side))],
                ["asymmetry there", f"{self._symmetry.asymmetry[here]:.4f}"],
                ["|s(p) − s(Tp)|", f"{abs(self._sum[here] - self._sum[self.image]):.4f}, ε = {self.epsilon:.4f}"],
            ]
        elif self._symmetry.found:
            rows.append(["mirror image", "none: it has no place on what is measured"])
        if self._shape.report:
            rows.append(["in place of the mesh", self._shape.report])
        self._info.value = controls.table([*rows, *self._shape.described(here)])

    def _draw_axis(self) -> None:
        if self._viewer is None or not self._symmetry.found:
            return
        curves = getattr(self._symmetry, "curve", ())
        if not curves:  # a symmetry of the user's own: from vertex to vertex, where its sides meet
            side = self._shape.on_measured(np.asarray(self._symmetry.side))
            curves = sign_changes(self._shape.measured, side)
        for number, curve in enumerate(curves):
            for pane in self._viewer.panes:
                pane.set_line(f"axis {number}", curve, _AXIS, 3.0)

    # -- colours ------------------------------------------------------------------------------------

    def _make_modes(self) -> dict[str, Any]:
        modes: dict[str, Any] = {}
        if self._symmetry.found:
            modes = {MIRRORED: self._mirrored_field, SIDES: self._side_field, ASYMMETRY: self._asymmetry_field}
            modes[DIFFERENCE] = self._difference_field
        modes |= {REGIONS: self._region_field, SUM: self._sum_field, EIGENFUNCTION: self._eigen_field}
        for name in self._shape.surface.attributes:
            modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
        return modes

    def _columns(self, mode: str) -> int:
        if mode == EIGENFUNCTION:
            return min(EIGENPAIRS, self._shape.measured.n_vertices)
        return self._shape.columns(mode.removeprefix(ATTRIBUTE)) if mode.startswith(ATTRIBUTE) else 1

    def _show_measure_controls(self) -> None:
        """Show the sliders of eq. (3) with the modes that they act on."""
        mode = str(self.mode)
        self._k0_slider.layout.display = "" if mode in (REGIONS, SUM) else "none"
        self._epsilon_slider.layout.display = "" if mode == REGIONS else "none"

    def _measure_changed(self) -> None:
        if str(self.mode) in (REGIONS, SUM):
            self._refresh()
        self._show_picked()

    @property
    def _measured_sum(self) -> FloatArray:
        return symmetry_sum(self._shape.spectrum, min(self.k0, self._shape.spectrum.k))

    @property
    def _sum(self) -> FloatArray:
        return self._shape.carried(self._measured_sum)

    @cached_property
    def _mirror_colors(self) -> FloatArray:
        axes = self._open_viewer.panes[0].placement.axes
        return mirror_colors(self._shape.surface.vertices, self._symmetry.p2p, axes)

    def _mirrored_field(self, k: int) -> Field:
        label = "a point and its mirror image have one colour; the line is the axis"
        alone = int((np.asarray(self._symmetry.p2p) < 0).sum())
        note = f"; grey: {alone} vertices without a place on what is measured" if alone else ""
        return ColorField([self._mirror_colors] * 2, label + note)

    def _side_field(self, k: int) -> Field:
        side = np.asarray(self._symmetry.side)
        numbers = np.where(side > 0, 0, np.where(side < 0, 1, -1))
        names = [_SIDE_NAMES[1], _SIDE_NAMES[-1]]
        loose = _SIDE_NAMES[0] + (", or no mirror image" if (np.asarray(self._symmetry.p2p) < 0).any() else "")
        return region_field([numbers] * 2, "the two sides and the axis between them", names, loose)

    def _asymmetry_field(self, k: int) -> Field:
        label = "asymmetry: mean |d(p, q) − d(Tp, Tq)| / √area"
        return ScalarField([np.asarray(self._symmetry.asymmetry, dtype=np.float64)] * 2, label)

    def _difference_field(self, k: int) -> Field:
        shape, p2p = self._shape, np.asarray(self._symmetry.p2p)
        places = getattr(self._symmetry, "barycentric", None)
        vertices = shape.surface.vertices
        images = np.where(p2p[:, None] >= 0, vertices[p2p], np.nan) if places is None else places.pulled_back(vertices)
        label = "out of the mirror image of the other side, along the normal, in the unit of the mesh"
        values = left_right_difference(shape.surface, images, shape.normals)
        return ScalarField([values] * 2, label, signed=True)

    def _region_field(self, k: int) -> Field:
        k0 = min(self.k0, self._shape.spectrum.k)
        regions = symmetry_regions(self._shape.spectrum, epsilon=self.epsilon, k0=k0)
        label = f"bands of the sum of the first {k0} eigenfunctions, ε = {self.epsilon:.3f} wide"
        return region_field([self._shape.carried(regions)] * 2, label)

    def _sum_field(self, k: int) -> Field:
        return ScalarField([self._sum] * 2, f"Σ |φₖ| √A over k ≤ {min(self.k0, self._shape.spectrum.k)} (no unit)")

    def _eigen_field(self, k: int) -> Field:
        return ScalarField([self._shape.eigenfunction(k)] * 2, f"φ, k = {k}, times √A (no unit)", True)

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field([self._shape.attribute(name, k)] * 2, name)

    def _page_extras(self) -> dict[str, Any]:
        if not self._symmetry.found:
            return {}
        image = np.asarray(self._symmetry.p2p)
        return {
            "partners": [image, image],
            "hint": "Click a point: its mirror image is marked in the other view.",
        }


def _checked(symmetry: Any, shape: Shape) -> Any:
    """The symmetry, where it is one of this mesh."""
    count = len(symmetry.p2p)
    if count != shape.surface.n_vertices:
        raise ParameterError(
            f"symmetry is one of {count} vertices, but the mesh has {shape.surface.n_vertices} as it was given: "
            "qg.self_symmetry(mesh, repair=...) is on those"
        )
    return symmetry
