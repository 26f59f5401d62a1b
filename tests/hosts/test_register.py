"""A host is one file: what `register_host` takes, and what a third party's mesh then goes through."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from shapes import icosphere

import qgeo_filters as qg
from qgeo_filters.hosts import protocol
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back
from qgeo_filters.hosts.protocol import load_host, registered_hosts

HOST = '''
"""A library of its own and its host, in one file."""

from dataclasses import dataclass, field, replace

import numpy as np

from qgeo_filters.io.raw_mesh import RawMesh


@dataclass
class Polyhedron:
    points: object
    triangles: object
    data: dict = field(default_factory=dict)
    owner: str = "nobody"


def read(mesh, repair):
    return RawMesh(mesh.points, mesh.triangles, mesh.data)


def write(mesh, attributes):
    return replace(mesh, data={**mesh.data, **attributes})


def with_positions(mesh, vertices):
    return replace(mesh, points=vertices)


def make(surface):
    return Polyhedron(np.array(surface.vertices), np.array(surface.faces), dict(surface.attributes), "make")
'''


@pytest.fixture
def register(monkeypatch):
    """The register as it is, and back to it afterwards."""
    monkeypatch.setattr(protocol, "REGISTER", dict(protocol.REGISTER))
    return qg.register_host


@pytest.fixture
def polyhedra(tmp_path, monkeypatch, register):
    """Module of a third party, registered by name and not imported yet."""
    (tmp_path / "polyhedra_of_others.py").write_text(HOST)
    monkeypatch.syspath_prepend(tmp_path)
    register("polyhedra_of_others", "polyhedra_of_others")
    assert "polyhedra_of_others" not in sys.modules
    yield lambda: __import__("polyhedra_of_others")
    sys.modules.pop("polyhedra_of_others", None)


def test_a_third_party_mesh_comes_in_and_goes_back_in_kind(polyhedra):
    module = polyhedra()
    vertices, faces = icosphere(1)
    mesh = module.Polyhedron(vertices, faces, {"own": np.arange(42)}, "me")
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, vertices)
    out = write_back(mesh, surface, {"new": np.ones(42)})
    assert type(out) is module.Polyhedron
    assert (set(out.data), out.owner, set(mesh.data)) == ({"own", "new"}, "me", {"own"})
    np.testing.assert_array_equal(with_positions(out, 2 * vertices).points, 2 * vertices)
    filtered = (qg.DifferentialCoordinates() | qg.SurfaceScalar())(mesh)
    assert type(filtered) is module.Polyhedron
    assert {"own", "qgeo_delta"} < set(filtered.data)


def test_check_filter_tries_every_registered_host(polyhedra, register):
    made = []
    module = polyhedra()
    seen = SimpleNamespace(
        read=module.read,
        write=module.write,
        with_positions=module.with_positions,
        make=lambda surface: made.append(surface) or module.make(surface),
    )
    register("polyhedra_of_others", seen)
    qg.testing.check_filter(qg.DifferentialCoordinates())
    assert len(made) == 1


def test_a_host_that_loses_an_attribute_does_not_pass(polyhedra, register):
    module = polyhedra()
    losing = SimpleNamespace(
        read=module.read,
        write=lambda mesh, attributes: module.write(mesh, {}),
        with_positions=module.with_positions,
        make=module.make,
    )
    register("polyhedra_of_others", losing)
    with pytest.raises(AssertionError, match="qgeo_delta does not reach polyhedra_of_others"):
        qg.testing.check_filter(qg.DifferentialCoordinates())


def test_subclasses_of_a_known_mesh_are_known(polyhedra):
    class Mine(polyhedra().Polyhedron):
        pass

    assert as_surface(Mine(*icosphere(1))).n_vertices == 42


@pytest.mark.parametrize("name", ["pyvista.core", "", 3, "a b"])
def test_a_name_that_no_module_has_is_refused(register, name):
    with pytest.raises(qg.ParameterError, match="first part of a module's name"):
        register(name, "json")


@pytest.mark.parametrize("how", ["object", "module"])
def test_a_host_without_its_functions_is_refused_with_their_names(register, how):
    if how == "object":
        with pytest.raises(qg.ParameterError, match="host of 'mine' has no function write, with_positions"):
            register("mine", SimpleNamespace(read=print))
    else:
        register("mine", "json")  # looked at when met
        with pytest.raises(qg.ParameterError, match="host of 'mine' has no function read, write, with_positions"):
            load_host("mine")


def test_the_packages_own_hosts_come_in_by_the_same_door():
    assert set(registered_hosts()) >= {"open3d", "pymeshlab", "pyvista", "trimesh"}
    for name in ("open3d", "pymeshlab", "pyvista", "trimesh"):
        pytest.importorskip(name)
        host = load_host(name)
        surface = qg.Surface(*icosphere(1), {"qgeo_a": np.arange(42.0)})
        again = as_surface(host.make(surface))
        np.testing.assert_array_equal(again.vertices, surface.vertices)
        np.testing.assert_array_equal(again.faces, surface.faces)
        np.testing.assert_array_equal(again.attributes["qgeo_a"], np.arange(42.0))
