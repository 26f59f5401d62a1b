"""The mesh that is shown, and the surface that is measured and matched in its place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from qgeo_filters._typing import RepairOption
from qgeo_filters.errors import MeshError
from qgeo_filters.filters import stages
from qgeo_filters.hosts.dispatch import as_given, as_surface, surface_and_repair
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.hosts.wrap import Wrap
from qgeo_filters.repair.triangle_soup import Pieces
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_repair


@dataclass(frozen=True, eq=False)
class ShownMesh:
    """A mesh as it was given, its repair, and what functions are to make of it.

    Attributes
    ----------
    surface : Surface
        With its own vertices, faces and attributes.
    repair : Repair, optional
        What is measured in its place; None: the mesh itself.
    to_match : (Surface or Repair, repair option)
        What matching takes: the repair, where that is of one piece.
    """

    surface: Surface
    repair: Repair | None
    to_match: tuple[Surface | Repair, RepairOption]

    @property
    def measured(self) -> Surface:
        """What distances, eigenfunctions and maps are of."""
        return self.surface if self.repair is None else self.repair.surface

    @classmethod
    def of(cls, mesh: Any, repair: RepairOption = "auto", pieces: Pieces = "largest") -> ShownMesh:
        """The mesh with the repair that the option asks for.

        Parameters
        ----------
        mesh : mesh object
            What `as_surface` takes. A `Repair` stands as it is, for the mesh that was given to it.
        repair : bool, "auto", "force" or "wrap"
            As in `match`. With "auto" what cannot be repaired to one piece is measured in all of its pieces, and what
            cannot be repaired at all as it is: then what cannot be measured there says so, when it is asked for.
        pieces : {"largest", "all"}
            What "auto" tries first: crumbs are left out of one piece.

        Raises
        ------
        MeshError
            What no `Surface` can hold, or cannot be repaired in the way that was asked for.
        """
        if isinstance(mesh, Repair):
            return cls(mesh.given, mesh, (mesh, False))
        if checked_repair(repair) == "wrap":
            given, notes = as_given(mesh, repair)
            wrap = wrap_around(given, stages.wrap_of(given), notes)  # wrapped once for all that is asked of it
            return cls(given, wrap, (wrap, False))
        if repair != "auto":
            surface, found = surface_and_repair(mesh, repair)
            return cls(surface, found, (found or surface, False))
        return cls._mended(mesh, pieces)

    @classmethod
    def _mended(cls, mesh: Any, pieces: Pieces) -> ShownMesh:
        tried: tuple[Pieces, ...] = ("largest", "all") if pieces == "largest" else ("all",)
        refusal: MeshError | None = None
        for kept in tried:
            try:
                surface, found = surface_and_repair(mesh, "auto", kept)
            except MeshError as error:
                refusal = refusal or error
            else:
                whole = found if kept == "largest" else None
                return cls(surface, found, (surface, "auto") if whole is None else (whole, False))
        try:
            surface = as_surface(mesh)
        except MeshError:
            raise refusal or MeshError("the mesh cannot be shown") from None
        return cls(surface, None, (surface, "auto"))


def wrap_around(given: Surface, wrap: Wrap, notes: tuple[str, ...] = ()) -> Wrap:
    """The wrap of equal vertices and faces as one of this mesh, with its attributes and what was left out of it."""
    if given is wrap.given and not notes:
        return wrap
    attributes = {name: values[wrap.origin] for name, values in given.attributes.items()}
    surface = Surface(wrap.surface.vertices, wrap.surface.faces, attributes)
    return replace(wrap, given=given, surface=surface, report=(*notes, *wrap.report))
