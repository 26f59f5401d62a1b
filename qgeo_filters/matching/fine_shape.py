"""A shape at the resolution at which maps are finished."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.decimation import Proxy
from qgeo_filters.matching.level import Level
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


class FineShape(Level):
    """What registration takes from a shape, its functions interpolated from a coarser level.

    Parameters
    ----------
    surface : Surface
    proxy : Proxy
        Of that surface; its surface is that of ``coarse``.
    coarse : Level
    """

    def __init__(self, surface: Surface, proxy: Proxy, coarse: Level) -> None:
        super().__init__(surface)
        self._proxy, self._coarse = proxy, coarse

    @cached_property
    def laplacian(self) -> SingleArray:
        """Eigenfunctions of the coarser level, interpolated within its triangles and brought to unit norm."""
        functions = self._proxy.pulled_back(self._coarse.laplacian)
        norms = np.sqrt(self.areas @ functions.astype(np.float64) ** 2)
        return frozen((functions / norms).astype(np.float32))

    @cached_property
    def log_hks(self) -> FloatArray:
        """Heat kernel signature of the coarser level, interpolated, (n, 3)."""
        return frozen(self._proxy.pulled_back(self._coarse.log_hks))

    @cached_property
    def fps(self) -> IndexArray:
        """The vertices nearest to the farthest points of the coarser level, in their order."""
        nearest = self._proxy.vertices[self._coarse.fps]
        _, first = np.unique(nearest, return_index=True)
        return frozen(nearest[np.sort(first)])
