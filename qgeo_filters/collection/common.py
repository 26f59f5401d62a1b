"""All shapes of a collection with one connectivity: what statistics of shapes start from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.places import MapLike, places_on, warned
from qgeo_filters.collection.remesh import laid_along
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.wrap import Wrap
from qgeo_filters.parallel import single_threaded_blas
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

# Of generalised Procrustes analysis: at most so many rounds, until the mean moves by less, in units of its size.
_ROUNDS, _STILL = 100, 1e-12


@dataclass(frozen=True, eq=False)
class CommonShapes:
    """Shapes whose vertices and triangles belong to each other one by one.

    Attributes
    ----------
    names : tuple of str
        The m shapes.
    template : Surface
        Whose n vertices, triangles and attributes all have.
    positions : (m, n, 3) float64
        Vertices of each.

    Examples
    --------
    >>> common = common_shapes(template, shapes, maps).aligned()
    >>> common.mean.write("mean.ply")
    >>> common.write("same")  # a PLY for each shape
    """

    names: tuple[str, ...]
    template: Surface
    positions: FloatArray

    def __post_init__(self) -> None:
        given = np.array(self.positions, dtype=np.float64)
        expected = (len(self.names), self.template.n_vertices, 3)
        if given.shape != expected:
            raise ParameterError(f"positions have shape {given.shape}, expected {expected}")
        if not self.names:
            raise ParameterError("there is no shape")
        lost = np.flatnonzero(~np.isfinite(given).all(axis=(1, 2)))
        if lost.size:
            raise ParameterError(f"{self.names[lost[0]]} has positions that are not finite ({lost.size} such shapes)")
        object.__setattr__(self, "positions", frozen(given))

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> Surface:
        """One of the shapes."""
        if name not in self.names:
            raise KeyError(f"no shape {name!r}; there are {', '.join(self.names)}")
        return self.template.with_vertices(self.positions[self.names.index(name)])

    @property
    def mean(self) -> Surface:
        """Mean of the positions: of shapes that are aligned, the mean shape."""
        return self.template.with_vertices(self.positions.mean(axis=0))

    def aligned(self, *, scale: bool = False) -> CommonShapes:
        """The same, each turned and moved (and scaled) onto their mean: generalised Procrustes analysis.

        Parameters
        ----------
        scale : bool
            Whether size goes as well. Where it does, all have the mean of the sizes (root mean square distance from
            the centre).

        Returns
        -------
        CommonShapes
            In the frame of the first shape, the centre in the origin. Vertices count by their area on the template.

        References
        ----------
        Gower, "Generalized Procrustes analysis", Psychometrika 40, 1975.
        """
        areas = self.template.vertex_areas
        share = areas / areas.sum()
        centred = self.positions - np.einsum("n,mni->mi", share, self.positions)[:, None]
        sizes = np.sqrt(np.einsum("n,mni->m", share, centred**2))
        if scale and not (sizes > 0).all():
            raise ParameterError(f"{self.names[int(sizes.argmin())]} is a single point and has no size to scale")
        size = sizes.mean()
        if scale:
            centred = centred * (size / sizes)[:, None, None]
        mean = centred[0]
        for _ in range(_ROUNDS):
            turned = np.stack([Similarity.between(one, mean, share, scale=1.0)(one) for one in centred])
            new = turned.mean(axis=0)
            new = new * (size / np.sqrt(share @ (new**2).sum(axis=1))) if scale else new
            moved = float(np.sqrt(share @ ((new - mean) ** 2).sum(axis=1)))
            mean, centred = new, turned
            if moved <= _STILL * size:
                break
        back = Similarity.between(mean, self.positions[0] - share @ self.positions[0], share, scale=1.0)
        return replace(self, positions=np.stack([back(one) for one in centred]) - share @ back(mean))

    def write(self, folder: str | PathLike[str], suffix: str = ".ply") -> list[Path]:
        """Write a mesh for each shape, NAME.ply, each whole or not there; the files, in the order of the names.

        Raises
        ------
        ParameterError
            A name that is no file's.
        """
        bad = [name for name in self.names if Path(name).name != name or name in ("", ".", "..")]
        if bad:
            raise ParameterError(f"{bad[0]!r} cannot be the name of a file ({len(bad)} such names)")
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        files = [target / f"{name}{suffix}" for name in self.names]
        for name, file in zip(self.names, files, strict=True):
            self[name].write(file)
        return files


def common_shapes(
    template: Surface,
    shapes: Mapping[str, Surface],
    maps: Mapping[str, MapLike],
    *,
    accept_unsure: bool = False,
    wraps: Mapping[str, Wrap] | None = None,
) -> CommonShapes:
    """All shapes with the connectivity of a template, see `remesh_like`.

    Parameters
    ----------
    template : Surface
        One of the shapes, or another.
    shapes : mapping of name to Surface
    maps : mapping of name to BarycentricMap, MatchResult or array-like of int
        The point, or vertex, of each shape for each vertex of the template. A shape that is the template needs none.
    accept_unsure : bool
        Whether matches that are not sure are used, with a warning.
    wraps : mapping of name to Wrap, optional
        Of the shapes that were wrapped, where their maps are no matches, which have their own: the template is put onto
        the closed surface, not onto walls inside.

    Raises
    ------
    ParameterError
        A shape without a map, or what `remesh_like` refuses; the message begins with the name.
    """
    missing = [name for name, shape in shapes.items() if name not in maps and not _same(shape, template)]
    if missing:
        raise ParameterError(f"no map from the template to {missing[0]} ({len(missing)} such shapes)")
    around = {} if wraps is None else wraps
    around_template = next((wrap for name, wrap in around.items() if _same(shapes[name], template)), None)
    positions = []
    with single_threaded_blas:
        for name, shape in shapes.items():
            with concerning(name):
                if _same(shape, template):
                    positions.append(shape.vertices)
                    continue
                both = around.get(name), around_template
                places = places_on(shape, template, maps[name], accept_unsure, wraps=both)
                one, doubts = laid_along(template, shape, places)
                warned([f"{name}: {doubt}" for doubt in doubts])
                positions.append(one.vertices)
    stacked: npt.NDArray[np.float64] = np.reshape(positions, (len(positions), template.n_vertices, 3))
    return CommonShapes(tuple(shapes), template, stacked)


def _same(shape: Surface, template: Surface) -> bool:
    return shape is template or (
        np.array_equal(shape.vertices, template.vertices) and np.array_equal(shape.faces, template.faces)
    )
