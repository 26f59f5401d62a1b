"""Paint: an attribute as vertex colours, for viewers that know nothing else."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
import numpy as np

from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.differential import SurfaceScalar
from qgeo_filters.filters.matching import SelfSymmetry
from qgeo_filters.filters.registry import registered
from qgeo_filters.report.colors import mirror_colors
from qgeo_filters.surface import Surface

# Attributes that are vertices of the same mesh.
_MIRROR_IMAGES = SelfSymmetry.index_outputs


@registered
class Paint(Filter):
    """Sets the vertex colours of the mesh from an attribute, where the host keeps its colours.

    Parameters
    ----------
    attribute : str
        Name of an attribute of the mesh, or one that an earlier step of the pipeline adds.
    component : int, optional
        Column of an attribute that has several; None takes the length of the vector.
    colormap : str
        A matplotlib colour map.
    vmin, vmax : float, optional
        Values of the first and last colour; the finite range of the attribute by default.
    centred : bool
        Same range on both sides of zero, for diverging colour maps.

    Notes
    -----
    Values that are not finite (unreachable, carried back from nowhere) are painted grey. The vertices of
    ``qgeo_symmetry`` are no quantities: a vertex and its mirror image get one colour, whatever the colour map.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> colored = (qg.SurfaceScalar() | qg.Paint(attribute="qgeo_scalar"))(surface).attributes["colors"]
    >>> colored.shape, bool(colored.min() >= 0), bool(colored.max() <= 1)
    ((162, 3), True, True)
    """

    pointwise = True

    outputs = {"colors": "(n, 3) float64 in [0, 1]: vertex colours, where the host keeps its own"}

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """After the filter that makes what is painted by default."""
        return SurfaceScalar() | cls()

    def __init__(
        self,
        attribute: str = "qgeo_scalar",
        *,
        component: int | None = None,
        colormap: str = "viridis",
        vmin: float | None = None,
        vmax: float | None = None,
        centred: bool = False,
    ) -> None:
        self.attribute = attribute
        self.component = component
        self.colormap = colormap
        self.vmin = vmin
        self.vmax = vmax
        self.centred = centred

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Colours by attribute name."""
        if self.attribute in _MIRROR_IMAGES and self.attribute in surface.attributes:
            images = np.asarray(surface.attributes[self.attribute]).reshape(-1)
            if len(images) == surface.n_vertices and ((images >= -1) & (images < surface.n_vertices)).all():
                return {"colors": mirror_colors(surface.vertices, images.astype(np.int64), np.eye(3))}
        values = self._values(surface)
        finite = np.isfinite(values)
        low = (
            self.vmin if self.vmin is not None else float(values[finite].min(initial=0 if not finite.any() else np.inf))
        )
        high = (
            self.vmax
            if self.vmax is not None
            else float(values[finite].max(initial=0 if not finite.any() else -np.inf))
        )
        if self.centred:
            high = max(abs(low), abs(high))
            low = -high
        if self.colormap not in matplotlib.colormaps:
            raise ParameterError(f"unknown colour map {self.colormap!r}; see matplotlib.colormaps")
        span = high - low
        scaled = np.where(finite, (values - low) / span if span > 0 else 0.5, 0.0)
        colors = matplotlib.colormaps[self.colormap](scaled)[:, :3]
        colors[~finite] = 0.6
        return {"colors": colors}

    def _values(self, surface: Surface) -> np.ndarray:
        if self.attribute not in surface.attributes:
            names = ", ".join(sorted(surface.attributes)) or "none"
            raise MeshError(f"there is no attribute {self.attribute!r} to paint; the mesh has {names}")
        values = np.asarray(surface.attributes[self.attribute], dtype=np.float64).reshape(surface.n_vertices, -1)
        if self.component is not None:
            if not 0 <= self.component < values.shape[1]:
                raise MeshError(
                    f"attribute {self.attribute!r} has {values.shape[1]} columns, but component is {self.component}"
                )
            return values[:, self.component]
        return values[:, 0] if values.shape[1] == 1 else np.linalg.norm(values, axis=1)
