"""Meshes that no repair can mend, only a wrap."""

from __future__ import annotations

import numpy as np
from shapes import Mesh


def in_pieces(mesh: Mesh, seed: int = 0) -> Mesh:
    """The mesh as 30 pieces that do not touch by an edge, half of them turned over, and a sheet across it inside."""
    vertices, faces = mesh
    random = np.random.default_rng(seed)
    middle = vertices[faces].mean(axis=1)
    piece = np.linalg.norm(middle[:, None] - middle[random.choice(len(faces), 30, replace=False)], axis=2).argmin(
        axis=1
    )
    soup, apart = [], []
    count = 0
    for label in range(30):
        used, local = np.unique(faces[piece == label], return_inverse=True)
        own = local.reshape(-1, 3) + count
        apart.append(own if label % 2 else own[:, ::-1])
        soup.append(vertices[used] * (1 + 2e-3 * random.random()))
        count += len(used)
    sheet = 0.2 * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    return np.concatenate([*soup, sheet]), np.concatenate([*apart, np.array([[0, 1, 2], [0, 2, 3]]) + count])
