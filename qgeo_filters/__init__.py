"""Curvature-guided quasi-geodesics, their spectrum, self-symmetry and correspondence for triangle meshes.

``import qgeo_filters as qg``; every public name is loaded on first use, so that the import is quick.
"""
