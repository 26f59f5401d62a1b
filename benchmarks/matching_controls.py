"""Negative controls: shapes without a symmetry, mirror images and other shapes, as a Markdown table.

    python benchmarks/matching_controls.py --seeds 10 [--json FILE]

All shapes are star-shaped bodies whose radius is a formula, so that any can be triangulated a second time, with every
direction known on both. A blob is a sphere displaced by nine waves about random axes; a creature has five unequal limbs
in random directions. Neither has a left and a right. A bent copy has other vertices as well.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator

import numpy as np
from geodesics_common import cpu
from record import Record, recorded
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation

import qgeo_filters as qg
from qgeo_filters.evaluation import geodesic_error

Radius = Callable[[np.ndarray], np.ndarray]
VERTICES = 800
MIRROR = np.array([-1, 1, 1])


def blob(seed: int) -> Radius:
    """Radius (n,) of a smooth blob for directions (n, 3)."""
    random = np.random.default_rng(seed)
    waves = [(degree, random.normal(size=3), random.normal()) for degree in (1, 2, 3) for _ in range(3)]

    def radius(directions: np.ndarray) -> np.ndarray:
        total = np.ones(len(directions))
        for degree, axis, height in waves:
            angle = np.arccos(np.clip(directions @ axis / np.linalg.norm(axis), -1, 1))
            total += 0.2 * height * np.cos(degree * angle)
        return np.maximum(total, 0.3)

    return radius


def creature(seed: int) -> Radius:
    """Radius (n,) of a body with five unequal limbs for directions (n, 3)."""
    axes = np.random.default_rng(seed).normal(size=(5, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    lengths = np.array([1.3, 1.0, 0.8, 0.6, 0.5])
    return lambda directions: 0.6 + np.exp(12 * (directions @ axes.T - 1)) @ lengths


def star(radius: Radius, seed: int, bend: float = 0.0) -> tuple[qg.Surface, np.ndarray]:
    """Body, and the direction of each vertex before it was bent; the seed turns the even spiral of directions."""
    i = np.arange(VERTICES) + 0.5
    z, angle = 1 - 2 * i / VERTICES, np.pi * (1 + np.sqrt(5)) * i
    ring = np.sqrt(1 - z**2)
    directions = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), z])
    directions = Rotation.random(random_state=seed).apply(directions)
    faces = ConvexHull(directions).simplices
    a, b, c = (directions[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward, ::-1]
    x, y, z = (radius(directions)[:, None] * directions).T
    turn = bend * y
    bent = np.column_stack([x, y * np.cos(turn) - z * np.sin(turn), y * np.sin(turn) + z * np.cos(turn)])
    return qg.Surface(bent, faces), directions


def mirrored(surface: qg.Surface) -> qg.Surface:
    """The mirror image, faces turned over so that they look outwards again."""
    return qg.Surface(surface.vertices * MIRROR, surface.faces[:, ::-1])


def controls(kind: Callable[[int], Radius], seed: int) -> Iterator[tuple[str, bool, str]]:
    """What is asked, whether the answer was yes, and what was said."""
    surface, directions = star(kind(seed), 0)
    shape = qg.PreparedShape(surface)
    symmetry = qg.self_symmetry(shape)
    yield "has a symmetry", symmetry.found, symmetry.reason
    found = qg.match(shape, mirrored(surface))
    yield "sure of its mirror image", found.confident, found.explanation
    found = qg.match(shape, star(kind(seed + 1), 0)[0])
    yield "sure of the next", found.confident, found.explanation
    other, theirs = star(kind(seed), 1, bend=0.2)
    found = qg.match(shape, other)
    _, truth = cKDTree(theirs).query(directions)
    error = float(geodesic_error(found.p2p, truth, other).mean())
    yield "sure of a bent copy", found.confident, f"{found.explanation}; error {error:.4f}"
    yield "bent copy right, mean error < .05", error < 0.05, f"{error:.4f}"


def main(record: Record) -> None:
    """Print each answer as a comment; then how many were yes, and how many should have been."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    arguments = parser.parse_args(record.arguments)
    counts: dict[str, dict[str, int]] = {}
    total = 0.0
    for label, kind in (("blob", blob), ("creature", creature)):
        for seed in range(arguments.seeds):
            answers, seconds = cpu(lambda kind=kind, seed=seed: list(controls(kind, seed)))
            total += seconds
            for question, yes, said in answers:
                counts.setdefault(question, {}).setdefault(label, 0)
                counts[question][label] += yes
                print(f"<!-- {label} {seed}, {question}: {'yes' if yes else 'no'}; {said} -->", flush=True)
    table = record.table("", f"of {arguments.seeds} shapes", "should be", "blobs", "creatures", align="lrrr")
    for question, yes in counts.items():
        right = arguments.seeds if "bent" in question else 0
        table.row(question, right, yes["blob"], yes["creature"])
    record.note(f"{total:.0f} CPU s.")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
