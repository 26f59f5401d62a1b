"""What construction, the geodesics and repair do with every mesh of the zoo."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import shared_data
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import bow_tie, icosphere
from zoo import GENERATED, Animal, files

from qgeo_filters.errors import MeshError, NonManifoldError
from qgeo_filters.geodesics.dijkstra import edge_distances
from qgeo_filters.geodesics.metric import cartesian_metric
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface

ANIMALS = GENERATED + (files(shared_data()) if (shared_data() / "malformed").is_dir() else [])


@pytest.fixture(params=ANIMALS, ids=lambda animal: animal.name)
def animal(request) -> Animal:
    return request.param


def snapshot(arrays):
    return None if isinstance(arrays, Path) else [np.array(a, copy=True) for a in arrays]


def test_construction_goes_through_or_names_the_fault(animal):
    arrays = animal.make()
    before = snapshot(arrays)
    if animal.construction is None:
        surface = as_surface(arrays)
        assert surface.vertices.dtype == np.float64
        assert surface.faces.dtype == np.int32
        if before is not None:
            np.testing.assert_array_equal(surface.vertices, before[0])
            np.testing.assert_array_equal(surface.faces, before[1])
    else:
        with pytest.raises(MeshError, match=animal.construction) as caught:
            as_surface(arrays)
        assert "\n" not in str(caught.value)
    if before is not None:
        for array, copy in zip(arrays, before, strict=True):
            np.testing.assert_array_equal(array, copy)


def test_geodesics_take_manifolds_and_name_what_is_none(animal):
    if animal.construction is not None:
        assert animal.geodesics is None
        return
    surface = as_surface(animal.make())
    if animal.geodesics is not None:
        with pytest.raises(NonManifoldError, match=f"needs a manifold mesh.*{animal.geodesics}.*repair=True"):
            cartesian_metric(surface).intrinsic()
        return
    distance = edge_distances(cartesian_metric(surface).intrinsic(), np.array([0]))[0]
    _, piece = surface.components
    np.testing.assert_array_equal(np.isfinite(distance), piece == piece[0])


def test_repair_makes_one_manifold_piece_and_says_what_it_did(animal):
    arrays = animal.make()
    before = snapshot(arrays)
    if animal.repair is not None:
        with pytest.raises(MeshError, match=animal.repair):
            repair_surface(arrays)
        return
    if animal.loss is not None:
        with pytest.raises(MeshError, match=animal.loss) as caught:
            repair_surface(arrays)
        assert "\n" not in str(caught.value)
    repair = repair_surface(arrays, force=animal.loss is not None)
    surface = repair.surface
    assert surface.is_manifold
    assert surface.components[0] == 1
    assert surface.unreferenced_vertices.size == 0
    assert repair.changed == bool(repair.report)
    assert any(re.search(animal.report, sentence) for sentence in repair.report or [""]), repair.report
    if animal.repaired is not None:
        assert repair.changed
        assert (surface.n_vertices, surface.n_faces) == animal.repaired
    elif before is not None:
        np.testing.assert_array_equal(surface.vertices, before[0])
        np.testing.assert_array_equal(surface.faces, before[1])
    if before is not None:
        np.testing.assert_array_equal(surface.vertices, np.array(before[0], dtype=float)[repair.origin])
    assert np.isfinite(edge_distances(cartesian_metric(surface).intrinsic(), np.array([0]))).all()


def test_repair_maps_back_and_forth(animal):
    if animal.repair is not None:
        return
    repair = repair_surface(animal.make(), force=animal.loss is not None)
    index = np.arange(repair.surface.n_vertices)
    back = repair.map_back(index)
    assert back.shape == repair.vertex_of_original.shape
    there = back >= 0
    np.testing.assert_array_equal(back, repair.vertex_of_original)
    vertices = repair.surface.vertices
    np.testing.assert_array_equal(repair.map_back(vertices)[there], vertices[back[there]])
    assert np.isnan(repair.map_back(vertices)[~there]).all()
    assert set(repair.origin) >= set(repair.origin[back[there]])


def test_a_second_repair_finds_nothing_to_do(animal):
    if animal.repair is not None:
        return
    once = repair_surface(animal.make(), force=animal.loss is not None).surface
    twice = repair_surface(once)
    assert [sentence for sentence in twice.report if "not orientable" not in sentence] == []
    np.testing.assert_array_equal(twice.surface.faces, once.faces)


def test_a_repaired_orientable_mesh_is_oriented(animal):
    if animal.repair is not None:
        return
    repair = repair_surface(animal.make(), force=animal.loss is not None)
    orientable = not any("not orientable" in sentence for sentence in repair.report)
    assert repair.surface.is_oriented == orientable


@pytest.mark.slow
@settings(max_examples=300)
@given(seed=st.integers(0, 2**32 - 1), n_vertices=st.integers(3, 14), n_faces=st.integers(1, 60))
def test_any_soup_becomes_one_manifold_piece(seed, n_vertices, n_faces):
    """Random triangles on few vertices: edges and vertices of every kind of badness, nested."""
    random = np.random.default_rng(seed)
    vertices, faces = random.random((n_vertices, 3)), random.integers(0, n_vertices, (n_faces, 3))
    if all(len(set(face)) < 3 for face in faces.tolist()):
        with pytest.raises(MeshError, match="nothing is left"):
            repair_surface((vertices, faces))
        return
    repair = repair_surface((vertices, faces), force=True)
    surface = repair.surface
    assert surface.is_manifold
    assert surface.components[0] == 1
    soup = {tuple(sorted(face)) for face in faces.tolist()}
    assert {tuple(sorted(face)) for face in repair.origin[surface.faces].tolist()} <= soup
    shuffled = np.roll(random.permutation(faces), 1, axis=1)
    assert repair_surface((vertices, shuffled), force=True).surface.is_manifold


def test_values_come_back_with_a_mark_where_a_vertex_is_gone():
    repair = repair_surface(next(animal for animal in GENERATED if animal.name == "NaN").make())
    n = repair.surface.n_vertices
    gone = repair.vertex_of_original < 0
    np.testing.assert_array_equal(np.flatnonzero(gone), [5])
    assert np.isnan(repair.map_back(np.zeros((n, 2)))[gone]).all()
    assert repair.map_back(np.zeros(n, np.int16))[5] == -1
    assert repair.map_back(np.zeros(n, np.int16)).dtype == np.int16
    assert repair.map_back(np.zeros(n, np.uint8))[5] == -1
    assert not repair.map_back(np.ones(n, bool))[5]
    with pytest.raises(MeshError, match=rf"do not fit the {n} repaired vertices"):
        repair.map_back(np.zeros(n + 1))


def test_attributes_follow_the_repair():
    vertices, faces = bow_tie()
    repair = repair_surface(Surface(vertices, faces, {"index": np.arange(5)}), force=True)
    np.testing.assert_array_equal(repair.surface.attributes["index"], repair.origin)
    with pytest.raises(MeshError, match="attribute 'a' has shape"):
        repair_surface(RawMesh(vertices, faces, {"a": np.arange(4)}))


def test_nothing_to_repair_gives_the_same_surface():
    surface = Surface(*icosphere(1))
    repair = repair_surface(surface)
    assert repair.surface is surface
    assert not repair.changed


def test_the_papers_meshes_run_or_are_refused_with_a_reason(data_dir):
    """One pose of each category; benchmarks/tosca_lowres.md lists them all."""
    for name in ("cat0", "centaur0", "dog0", "horse0", "lioness0", "michael0", "seahorse0", "victoria0", "wolf0"):
        surface = as_surface(data_dir / "tosca" / "lowres" / name)
        if surface.is_manifold:
            cartesian_metric(surface).intrinsic()
        else:
            with pytest.raises(NonManifoldError, match=r"edge \(\d+, \d+\) has \d faces"):
                cartesian_metric(surface).intrinsic()
        in_parts = name == "lioness0"  # eyes and fangs are sheets of their own
        if in_parts:
            with pytest.raises(MeshError, match=r"repair would remove 6\.\d+ % of the area"):
                repair_surface(surface)
        repaired = repair_surface(surface, force=in_parts).surface
        assert repaired.is_manifold
        assert repaired.components[0] == 1
        assert repaired.area > 0.92 * surface.area
    with pytest.raises(MeshError, match=r"victoria14\.tri is empty"):
        as_surface(data_dir / "tosca" / "lowres" / "victoria14")
