r"""Whether the poses of a shape are spectrally compatible: D(S), eq. (5) of the paper.

The paper optimises the eigenspectra of two baseline poses against each other (eq. 4), carries the result to all others
(Fig. 3), and sums up in D(S) how far the set S of poses is from sharing one eigenspectrum. Two readings are taken here:

* *Carried* means: the baselines fix which eigenfunctions take part and in what order; each other pose gives, for
  each of them, the eigenfunction and sign that couple best with those of both baselines. No pose is optimised against
  any but the baselines.
* The printed sum has no unit and grows with the number of poses. Here D(S) is the mean of
  :math:`C_{XY} = \sum_k \|\phi_X^k - \phi_Y^k\|_2` over all pairs of poses, all functions being read on the vertices
  of the first baseline. So D(S) of different sets can be compared, and is 0 if the poses are isometric.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray, IndexArray, RepairOption
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.errors import MeshError, ParameterError, concerning
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.hosts.dispatch import SurfaceLike, surface_and_repair
from qgeo_filters.hosts.given_images import images_on_given
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.html_repr import MOST_ROWS, card
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.parallel import default_workers
from qgeo_filters.spectral.commutative import Normalization, commutative_eigenspectra, spectral_distance
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices, frozen

# Eigenpairs beyond those that are compared, so that a function near the end finds its partner in other poses.
SPARE_EIGENPAIRS = 5


@dataclass(frozen=True, eq=False)
class Compatibility:
    """How far a set of poses is from having one eigenspectrum.

    Attributes
    ----------
    d_s : float
        D(S): mean of ``c_xy`` over all pairs of poses. 0 for isometric poses.
    c_xy : (p, p) float64
        Distance of each two poses by their carried eigenfunctions; symmetric, zero diagonal.
    index : (p, m) int64
        Which eigenfunction of each pose stands for each of the m common ones.
    signs : (p, m) float64
        1 or -1 for each of them.
    eigenvalues : (p, m) float64
        Of each pose, in the common order.
    baselines : (int, int)
    maps : tuple of (n,) int64
        Vertex of each pose for each vertex of the first baseline.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> found = qg.compatibility([x, x.with_vertices(2 * x.vertices)], k=4)
    >>> round(found.d_s, 3), found.index.shape, len(found.maps)
    (0.0, (2, 4), 2)
    """

    d_s: float
    c_xy: FloatArray
    index: IndexArray
    signs: FloatArray
    eigenvalues: FloatArray
    baselines: tuple[int, int]
    maps: tuple[IndexArray, ...]

    def __repr__(self) -> str:
        count, common = self.index.shape
        pairs = self.c_xy[np.triu_indices(count, 1)]
        return (
            f"Compatibility({count} poses, D(S) = {self.d_s:.4g}, C_XY from {pairs.min():.4g} to {pairs.max():.4g}, "
            f"{common} common eigenfunctions)"
        )

    def _repr_html_(self) -> str:
        count, common = self.index.shape
        facts = {"D(S)": self.d_s, "common eigenfunctions": common, "baselines": list(self.baselines)}
        few = count <= MOST_ROWS
        table = [(str(k), *map(float, row)) for k, row in enumerate(self.c_xy)] if few else []
        columns = ("C_XY", *map(str, range(count))) if few else ()
        return card(f"Compatibility of {count} poses", facts, table=table, columns=columns)


@renamed_parameters(weight="curvature_weight")
def compatibility(
    surfaces: Sequence[SurfaceLike],
    baselines: tuple[int, int] = (0, 1),
    *,
    k: int = 20,
    curvature_weight: float = CURVATURE_WEIGHT,
    maps: Sequence[npt.ArrayLike] | None = None,
    normalization: Normalization = "area",
    repair: RepairOption = "auto",
    workers: int | None = None,
    progress: bool = False,
) -> Compatibility:
    """Compatibility of the eigenspectra of a set of poses, D(S) (paper, eq. 5).

    Parameters
    ----------
    surfaces : sequence of Surface, or of whatever `as_surface` takes
        Two poses or more.
    baselines : (int, int)
        Indices of the two poses whose eigenspectra are optimised against each other.
    k : int
        Number of eigenfunctions that are compared.
    curvature_weight : float
        Of the curvature scalar in the metric, see `lifted_metric`, whose default it is; 0 is the Cartesian metric.
    maps : sequence of array-like of int, optional
        For each pose, its vertex for each vertex of the first baseline. By default vertex i is the same point of all
        poses if they have the same faces (poses of one mesh, as in the paper); the maps are found by `match` if not.
    normalization : {"area", "vertices"}
        Of C_XY, see `spectral_distance`.
    repair : bool, "auto" or "force"
        Whether poses are made manifold, oriented and one piece first: by default, "auto", those that are not. Maps,
        those that are given too, are between the vertices that were given, -1 for one that is gone.
    workers : int, optional
        Threads; all cores that the process may use by default.
    progress : bool
        Whether to show progress bars over distances.

    Raises
    ------
    ValueError
        Fewer than two poses, baselines out of range or equal, maps that do not fit, k out of range.
    MeshError
        See `distance_spectrum` and `match`.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> poses = [x, x.with_vertices(2 * x.vertices), x.with_vertices(x.vertices * [1, 1, 1.1])]
    >>> found = qg.compatibility(poses, k=4)
    >>> found.c_xy.round(2)
    array([[0.  , 0.  , 0.08],
           [0.  , 0.  , 0.08],
           [0.08, 0.08, 0.  ]])
    """
    poses, repairs = [], []
    for number, surface in enumerate(surfaces):
        with concerning(f"surfaces[{number}]"):
            given_pose, mended = surface_and_repair(surface, repair)
            poses.append(given_pose if mended is None else mended.surface)
            repairs.append(mended)
    check_baselines(len(poses), baselines)
    first = baselines[0]
    with default_workers(workers):
        if maps is None:
            given: Sequence[npt.ArrayLike] = _default_maps(poses, first, progress)
        else:
            given = [_on_repaired(image, repairs[first], repairs[p], p) for p, image in enumerate(maps)]
        spectra = []
        for number, pose in enumerate(poses):
            with concerning(f"surfaces[{number}]"):
                metric = lifted_metric(pose, curvature_weight=curvature_weight)
                count = min(k + SPARE_EIGENPAIRS, pose.n_vertices) if isinstance(k, (int, np.integer)) else k
                spectra.append(distance_spectrum(pose, count, metric, progress=progress))
    found = compatibility_of_spectra(spectra, given, baselines, k=k, normalization=normalization)
    if all(mended is None for mended in repairs):
        return found
    return replace(
        found,
        maps=tuple(images_on_given(image, repairs[first], repairs[p], poses[p]) for p, image in enumerate(found.maps)),
    )


def _on_repaired(image: npt.ArrayLike, of: Repair | None, on: Repair | None, number: int) -> npt.ArrayLike:
    """A map between given vertices as one between the repaired ones."""
    if of is None and on is None:
        return image
    count = None if of is None else len(of.vertex_of_original)
    limit = np.iinfo(np.int64).max if on is None else len(on.vertex_of_original)
    there = checked_indices(image, limit, f"maps[{number}]")
    if count is not None and len(there) != count:
        raise ParameterError(
            f"maps[{number}] must hold a vertex for each of the {count} of the first baseline, got {len(there)}"
        )
    there = there if of is None else there[of.origin]
    there = there if on is None else on.vertex_of_original[there]
    if (there < 0).any():
        count = int((there < 0).sum())
        raise MeshError(f"maps[{number}] leads to vertices that had to go when the pose was repaired ({count} such)")
    return there


def compatibility_of_spectra(
    spectra: Sequence[Spectrum],
    maps: Sequence[npt.ArrayLike],
    baselines: tuple[int, int] = (0, 1),
    *,
    k: int = 20,
    normalization: Normalization = "area",
) -> Compatibility:
    """Compatibility of eigenspectra that are at hand; parameters as in `compatibility`.

    A few eigenpairs more than k in each spectrum let functions near the end find their partners.
    """
    check_baselines(len(spectra), baselines)
    first, second = baselines
    images = _checked_maps(spectra, maps, first)
    weights = spectra[first].areas / spectra[first].areas.sum()
    read = [
        spectrum.eigenfunctions[image] * np.sqrt(spectrum.areas.sum())
        for spectrum, image in zip(spectra, images, strict=True)
    ]
    pair = commutative_eigenspectra(spectra[first], _on_first(spectra, read, first, second), np.arange(len(weights)), k)
    index = np.empty((len(spectra), k), dtype=np.int64)
    signs = np.ones((len(spectra), k))
    index[first], index[second], signs[second] = pair.index_x, pair.index_y, pair.signs
    common = pair.functions_x + pair.functions_y
    for pose in range(len(spectra)):
        if pose not in baselines:
            products = common.T @ (weights[:, None] * read[pose])
            _, index[pose] = linear_sum_assignment(products**2, maximize=True)
            signs[pose] = np.where(products[np.arange(k), index[pose]] < 0, -1.0, 1.0)
    carried = [functions[:, chosen] * sign for functions, chosen, sign in zip(read, index, signs, strict=True)]
    c_xy = np.zeros((len(spectra), len(spectra)))
    for i, j in itertools.combinations(range(len(spectra)), 2):
        c_xy[i, j] = c_xy[j, i] = spectral_distance(carried[i], carried[j], weights, normalization)
    return Compatibility(
        float(c_xy[np.triu_indices(len(spectra), 1)].mean()),
        frozen(c_xy),
        frozen(index),
        frozen(signs),
        frozen(np.array([spectrum.eigenvalues[chosen] for spectrum, chosen in zip(spectra, index, strict=True)])),
        (int(first), int(second)),
        tuple(frozen(image) for image in images),
    )


def _on_first(spectra: Sequence[Spectrum], read: list[FloatArray], first: int, second: int) -> Spectrum:
    """The second baseline's eigenfunctions on the vertices of the first."""
    areas = spectra[first].areas
    functions = read[second] / np.sqrt(areas.sum())
    return Spectrum(spectra[second].eigenvalues, functions, areas, spectra[second].multiplets)


def _default_maps(poses: list[Surface], first: int, progress: bool) -> list[IndexArray]:
    """Equal indices for poses of one mesh, otherwise the correspondences from the first baseline."""
    n = poses[first].n_vertices
    if are_one_mesh(poses):
        return [np.arange(n)] * len(poses)
    with concerning(f"surfaces[{first}]"):
        reference = PreparedShape(poses[first], progress=progress)
    maps = []
    for number, pose in enumerate(poses):
        if number == first:
            maps.append(np.arange(n))
            continue
        with concerning(f"surfaces[{number}]"):
            shape = PreparedShape(pose, progress=progress)
        maps.append(match(reference, shape, partial=False, progress=progress).p2p)
    return maps


def are_one_mesh(poses: Sequence[Surface]) -> bool:
    """Whether vertex i is the same point of all poses: they have the same faces."""
    one = poses[0]
    return all(pose.n_vertices == one.n_vertices and np.array_equal(pose.faces, one.faces) for pose in poses)


def check_baselines(count: int, baselines: tuple[int, int]) -> None:
    """Raise `ParameterError` for fewer than two poses, and for baselines that are not two of them."""
    if count < 2:
        raise ParameterError(f"compatibility is that of two poses or more, got {count}")
    if len(baselines) != 2 or baselines[0] == baselines[1] or not all(0 <= b < count for b in baselines):
        raise ParameterError(f"baselines must be two different poses out of 0 to {count - 1}, got {baselines!r}")


def _checked_maps(spectra: Sequence[Spectrum], maps: Sequence[npt.ArrayLike], first: int) -> list[IndexArray]:
    if len(maps) != len(spectra):
        raise ParameterError(f"one map for each of the {len(spectra)} poses is needed, got {len(maps)}")
    n = spectra[first].n_vertices
    images = []
    for number, (spectrum, image) in enumerate(zip(spectra, maps, strict=True)):
        checked = checked_indices(image, spectrum.n_vertices, f"maps[{number}]")
        if len(checked) != n:
            raise ParameterError(
                f"maps[{number}] must hold a vertex for each of the {n} of the first baseline, got {len(checked)}"
            )
        images.append(checked)
    return images
