"""Where the nodes of a glTF scene place its meshes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.gltf_document import Document, extensions

_INSTANCES = "EXT_mesh_gpu_instancing"


class PlacedMesh(NamedTuple):
    """A mesh as one node shows it: its entry and name, the node's 4 x 4 matrix, and the pose that is passed over."""

    entry: dict[str, Any]
    name: str
    placement: FloatArray
    pose: str | None


def placed_meshes(document: Document) -> Iterator[PlacedMesh]:
    """Each mesh of the scene, once for each node that shows it; without nodes, each mesh as it stands.

    Raises
    ------
    MeshError
        Nodes that are below themselves, or shown twice; placements that are none.
    """
    if not document.elements("nodes"):
        for index in range(len(document.elements("meshes"))):
            yield _placed(document, {"mesh": index}, "the file", np.eye(4))
        return
    waiting = [(root, np.eye(4)) for root in reversed(_roots(document))]
    met: set[int] = set()
    while waiting:
        index, above = waiting.pop()
        name = f"nodes[{index}]"
        node = document.element("nodes", index, "the scene")
        if index in met:
            raise MeshError(f"{name} stands in the scene twice, or below itself")
        met.add(index)
        placement = above @ _local_matrix(node, name)
        waiting += [(child, placement) for child in reversed(_indices(node, "children", name))]
        if "mesh" in node:
            yield _placed(document, node, name, placement)


def _placed(document: Document, node: dict[str, Any], name: str, placement: FloatArray) -> PlacedMesh:
    if _INSTANCES in extensions(node, name):
        raise MeshError(f"{name} repeats its mesh by {_INSTANCES}, which is not read; write the file without")
    mesh = document.element("meshes", node["mesh"], name)
    weights = node.get("weights", mesh.get("weights"))
    morphed = isinstance(weights, list) and any(weights)
    pose = "skin" if "skin" in node else "morph targets" if morphed else None
    return PlacedMesh(mesh, f"meshes[{node['mesh']}]", placement, pose)


def _roots(document: Document) -> list[int]:
    """Nodes of the scene that is to be shown; where the file has none, those that stand below no other."""
    if document.elements("scenes"):
        scene = document.element("scenes", document.tree.get("scene", 0), "the file")
        return _indices(scene, "nodes", "the scene")
    nodes = range(len(document.elements("nodes")))
    below = {
        child
        for index in nodes
        for child in _indices(document.element("nodes", index, "the file"), "children", f"nodes[{index}]")
    }
    return [index for index in nodes if index not in below]


def _indices(entry: dict[str, Any], key: str, name: str) -> list[int]:
    found = entry.get(key, [])
    if not isinstance(found, list) or not all(type(index) is int for index in found):
        raise MeshError(f"{key} of {name} are no list of indices")
    return found


def _local_matrix(node: dict[str, Any], name: str) -> FloatArray:
    """Matrix of a node relative to the one above: as it stands, or of translation, rotation and scale."""
    from scipy.spatial.transform import Rotation  # half a second, which a command that reads no scene need not wait

    matrix = np.eye(4)
    try:
        if "matrix" in node:
            return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
        if "rotation" in node:
            matrix[:3, :3] = Rotation.from_quat(np.array(node["rotation"], dtype=np.float64).reshape(4)).as_matrix()
        matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64).reshape(3)
        matrix[:3, 3] = np.array(node.get("translation", (0, 0, 0)), dtype=np.float64).reshape(3)
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(f"the placement of {name} cannot be read ({reason(error)})") from error
    return matrix
