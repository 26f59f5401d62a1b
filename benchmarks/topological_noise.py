"""`qg.match` of surfaces that have grown together onto a clean pose: poses of TOSCA made so, or a folder of such.

    python benchmarks/topological_noise.py ROOT [--categories michael victoria] [--folder FOLDER --clean null] [--truth]

ROOT as for ``matching.py``. Each pose is offset outwards by .02 sqrt(area) and sampled anew on a grid of .012, so that
hands on hips and thighs on calves coalesce, as in SHREC'16's TOPKIDS; its largest piece at 5000 vertices is matched
with pose 0 as it is. Poses that stay without a handle are left out. True are the vertices of the pose whose nearest
vertex on the new surface lies within .035 and faces the same way. FOLDER holds surfaces like that, as
`qgeo_filters.evaluation` reads them; ``--clean`` names what they are matched with. Direct errors over sqrt(area of Y).
"usual" leaves out the search that lets distances be shorter (`robust_to_shortcuts`). CPU seconds of
a match of prepared shapes; the symmetry of Y is found in the first one.

With ``--truth`` the map that is found and the true one are placed and registered in the same way, as the search does:
where the true one costs less, it was not proposed; where it costs more, costs do not tell. Errors are those of the
places, between coarse shapes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from unittest.mock import patch

import numpy as np
import pymeshlab
from geodesics_common import cpu
from record import Table, machine, recorded
from scipy.spatial import cKDTree

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed, VtsDataset, geodesic_error
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.placement import Placement
from qgeo_filters.matching.problem import MatchProblem

OFFSET, GRID, NEAR, FACES = 0.02, 0.012, 0.035, 10_000
WRONG = 0.1


def grown_together(surface: qg.Surface) -> qg.Surface:
    """The surface offset outwards and sampled anew."""
    unit = np.sqrt(surface.area)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    meshes.generate_resampled_uniform_mesh(
        cellsize=pymeshlab.PureValue(GRID * unit), offset=pymeshlab.PureValue(OFFSET * unit), mergeclosevert=True
    )
    meshes.generate_splitting_by_connected_components()
    meshes.set_current_mesh(max(range(2, len(meshes)), key=lambda i: meshes.mesh(i).face_number()))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=FACES, preservetopology=True)
    meshes.meshing_repair_non_manifold_edges()
    meshes.meshing_repair_non_manifold_vertices()
    mesh = meshes.current_mesh()
    return qg.Surface(mesh.vertex_matrix(), mesh.face_matrix())


def tosca(root: str, categories: list[str]) -> Iterator[tuple[str, qg.Surface, qg.Surface, np.ndarray]]:
    """Name, X with handles, Y, and the true vertex of Y for each of X, -1 where it is not known."""
    data = ToscaRemeshed(root)
    for category in categories:
        names = [name for name in data.names() if data.category(name) == category]
        clean = f"{category}0"
        y = qg.as_surface(data.read(clean))
        for name in names:
            pose = qg.as_surface(data.read(name))
            x = grown_together(pose)
            if name == clean or not x.genus:
                continue
            known = data.truth(clean, name)
            distance, vertex = cKDTree(x.vertices).query(pose.vertices[known.images])
            same_side = (x.vertex_normals[vertex] * pose.vertex_normals[known.images]).sum(axis=1) > 0
            told = (distance < NEAR * np.sqrt(pose.area)) & same_side
            truth = np.full(x.n_vertices, -1)
            truth[vertex[told]] = known.points[told]
            yield name, x, y, truth


def folder(root: str, clean: str) -> Iterator[tuple[str, qg.Surface, qg.Surface, np.ndarray]]:
    """The same of a folder."""
    data = VtsDataset(root)
    y = qg.as_surface(data.read(clean))
    for name in data.names():
        if name != clean:
            x, known = qg.as_surface(data.read(name)), data.truth(name, clean)
            truth = np.full(x.n_vertices, -1)
            truth[known.points] = known.images
            yield name, x, y, truth


def rows(table: Table, pairs: Iterator[tuple[str, qg.Surface, qg.Surface, np.ndarray]]) -> None:
    """A row for each pair, and their means."""
    errors: list[tuple[float, float]] = []
    clean: dict[int, qg.PreparedShape] = {}
    for name, surface, target, truth in pairs:
        y = clean.setdefault(id(target), qg.PreparedShape(target))
        x = qg.PreparedShape(surface)
        x.prepare()
        y.prepare()
        with patch("qgeo_filters.matching.correspondence.robust_to_shortcuts", lambda _, found: found):
            usual, before = cpu(lambda x=x, y=y: qg.match(x, y))
        found, after = cpu(lambda x=x, y=y: qg.match(x, y))
        error = tuple(float(np.nanmean(m.error(truth))) for m in (usual, found))
        errors.append(error)
        said = ["sure" if m.confident else "unsure" for m in (usual, found)]
        table.row(
            name,
            surface.genus,
            f"{error[0]:.3f} {said[0]}",
            f"{error[1]:.3f} {said[1]}",
            f"{before:.0f}",
            f"{after:.0f}",
        )
    if errors:
        mean, wrong = np.mean(errors, axis=0), (np.array(errors) > WRONG).sum(axis=0)
        cells = [f"{m:.3f}, {w} of {len(errors)} wrong" for m, w in zip(mean, wrong, strict=True)]
        table.row("mean", "", *cells, "", "")


def places(table: Table, pairs: Iterator[tuple[str, qg.Surface, qg.Surface, np.ndarray]]) -> None:
    """A row for each pair: the place that is found beside the true one."""
    clean: dict[int, qg.PreparedShape] = {}
    for name, surface, target, truth in pairs:
        y = clean.setdefault(id(target), qg.PreparedShape(target))
        x = qg.PreparedShape(surface)
        back = MatchProblem.of(y, x)  # from the one without handles
        placement = Placement(back, PartialParameters.of_grown_surfaces())
        left = np.arange(len(truth)) if x.repair is None else x.repair.vertex_of_original
        known = np.flatnonzero((truth >= 0) & (left >= 0))
        nearest = cKDTree(target.vertices[truth[known]]).query(target.vertices[y.full_vertices])[1]
        full = qg.match(x, y).inverse[y.full_vertices], known[nearest]
        images = [placement.at_points(x.vertex_of_full[left[vertices]]) for vertices in full]
        compared = placement.compared
        found, true = compared.placed([(compared.proposed(p2p, "given"), p2p) for p2p in images])
        errors = [
            geodesic_error(y.full_vertices[place.map.back[x.vertex_of_full[left[known]]]], truth[known], target).mean()
            for place in (found, true)
        ]
        table.row(name, surface.genus, *(f"{error:.3f}" for error in errors), f"{found.cost / true.cost:.2g}")


def main() -> None:
    """Print a table for each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="*", default=["michael", "victoria"])
    parser.add_argument("--folder")
    parser.add_argument("--clean", default="null")
    parser.add_argument("--truth", action="store_true")
    with recorded() as record:
        given = parser.parse_args(record.arguments)
        print(machine())
        columns: tuple[str, ...] = "X", "handles", "usual", "shorter distances, too", "CPU s, usual", "CPU s"
        align, fill = "lrllrr", rows
        if given.truth:
            columns = "X", "handles", "error of the place found", "of the true one", "cost, found : true"
            align, fill = "lrrrr", places
        for category in given.categories:
            fill(record.table(category, *columns, align=align), tosca(given.root, [category]))
        if given.folder:
            fill(record.table("as given", *columns, align=align), folder(given.folder, given.clean))


if __name__ == "__main__":
    main()
