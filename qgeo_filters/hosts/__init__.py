"""Meshes of other libraries; the package's own hosts are in the register before anyone can add to it."""

from qgeo_filters.hosts.protocol import register_host

register_host("meshio", "qgeo_filters.hosts.meshio")
register_host("open3d", "qgeo_filters.hosts.open3d")
register_host("pymeshlab", "qgeo_filters.hosts.meshlab")
register_host("pyvista", "qgeo_filters.hosts.pyvista")
register_host("trimesh", "qgeo_filters.hosts.trimesh")
register_host("vedo", "qgeo_filters.hosts.vedo")
