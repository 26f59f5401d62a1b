"""A statistical shape model: the mean of shapes and the directions in which they vary most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.collection.common import CommonShapes
from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count, frozen


@dataclass(frozen=True, eq=False)
class ShapeModel:
    """Mean and modes of variation.

    Attributes
    ----------
    mean : Surface
    modes : (k, n, 3) float64
        Displacements of the vertices, orthonormal, by decreasing variance.
    variance : (k,) float64
        Along each mode, in squared mesh units summed over the vertices, of m - 1 degrees of freedom.
    explained : (k,) float64
        Its share of all variance.
    scores : (m, k) float64
        Each shape by its place along the modes, in standard deviations.
    names : tuple of str
        Of the shapes.
    """

    mean: Surface
    modes: FloatArray
    variance: FloatArray
    explained: FloatArray
    scores: FloatArray
    names: tuple[str, ...]

    def mode(self, k: int, sigma: float) -> Surface:
        """The mean moved by so many standard deviations along mode k, from 0.

        Raises
        ------
        ParameterError
            A mode that there is not.
        """
        if not 0 <= k < len(self.modes):
            raise ParameterError(f"mode {k} is not there: there are {len(self.modes)}, numbered from 0")
        return self.mean.with_vertices(self.mean.vertices + sigma * np.sqrt(self.variance[k]) * self.modes[k])

    def shape(self, scores: FloatArray) -> Surface:
        """The shape of some scores, (k,) or fewer, in standard deviations."""
        given = np.asarray(scores, dtype=np.float64)
        if given.ndim != 1 or len(given) > len(self.modes):
            raise ParameterError(f"scores must be at most {len(self.modes)} numbers, got shape {given.shape}")
        moves = np.einsum("k,kni->ni", given * np.sqrt(self.variance[: len(given)]), self.modes[: len(given)])
        return self.mean.with_vertices(self.mean.vertices + moves)


def shape_model(shapes: CommonShapes, modes: int | None = None) -> ShapeModel:
    """Principal components of shapes that are aligned, see `CommonShapes.aligned`.

    Parameters
    ----------
    shapes : CommonShapes
    modes : int, optional
        How many; all, one less than there are shapes, by default.

    Raises
    ------
    ParameterError
        Fewer than two shapes, or more modes than there are.
    MissingPackageError
        Without scikit-learn.
    """
    most = min(len(shapes) - 1, 3 * shapes.template.n_vertices)
    if most < 1:
        raise ParameterError("a shape model needs at least two shapes")
    count = most if modes is None else checked_count(modes, 1, most, "modes")
    pca = require_package("sklearn.decomposition", "collections", "a shape model").PCA(count, svd_solver="full")
    scores = pca.fit_transform(shapes.positions.reshape(len(shapes), -1))
    spread = np.sqrt(pca.explained_variance_)
    return ShapeModel(
        shapes.mean,
        frozen(pca.components_.reshape(count, -1, 3)),
        frozen(pca.explained_variance_),
        frozen(pca.explained_variance_ratio_),
        frozen(np.divide(scores, spread, out=np.zeros_like(scores), where=spread > 0)),
        shapes.names,
    )
