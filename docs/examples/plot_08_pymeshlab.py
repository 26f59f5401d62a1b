"""
A pipeline in PyMeshLab
=======================

Filters compose with ``|``. What they add are custom attributes that PyMeshLab's own filters understand.
"""

import tempfile
from pathlib import Path

import pymeshlab

import qgeo_filters as qg
from qgeo_filters.report.figures import plot_attribute

meshes = pymeshlab.MeshSet(verbose=False)
meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"))
pipe = qg.CorrectedNormals() | qg.Curvatures() | qg.QuasiGeodesicSpectrum(k=6)
pipe

# %%
out = pipe(meshes)
out.compute_selection_by_condition_per_vertex(condselect="qgeo_phi_1 > 0")
out.current_mesh().selected_vertex_number(), out.current_mesh().vertex_number()

# %%
# Beside filters there are methods in PyMeshLab's own style.
print("\n".join(qg.register_pymeshlab()))
meshes.compute_scalar_by_quasi_geodesic_spectrum_per_vertex(component=2, k=6)
meshes.current_mesh().vertex_scalar_array().round(3)

# %%
# A pipeline is saved as YAML, for ``qgeo run pipe.yaml MESH``.
with tempfile.TemporaryDirectory() as folder:
    pipe.save(Path(folder) / "pipe.yaml")
    print((Path(folder) / "pipe.yaml").read_text())

# %%
surface = qg.as_surface(out)
plot_attribute(surface, "qgeo_phi", surface.attributes["qgeo_phi"][:, :3])
