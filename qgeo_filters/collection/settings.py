"""What the results of a collection depend on besides its shapes, and the keys by which they are found again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import MirrorOption, PartialOption, RepairOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.fingerprint import code_digest
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.registration_stages import Stage
from qgeo_filters.matching.search import checked_mirror
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_repair

#: How records are laid out, and what is in them.
FORMAT = 1


@dataclass(frozen=True)
class Settings:
    """How shapes are prepared and matched, see `match`; goes to worker processes as it is.

    Attributes
    ----------
    parameters : MatchingParameters
    normalize : bool
    partial : bool or "auto"
    mirror : {"auto", "no", "yes"}
    repair : bool, "auto", "force" or "wrap"
    code : str
        Digest of the package that asks: no result of another one is taken for its own.
    """

    parameters: MatchingParameters = field(default_factory=MatchingParameters)
    normalize: bool = True
    partial: PartialOption = "auto"
    mirror: MirrorOption = "auto"
    repair: RepairOption = "auto"
    code: str = field(default_factory=code_digest)

    def __post_init__(self) -> None:
        checked_mirror(self.mirror)
        checked_repair(self.repair)
        if self.partial not in (True, False, "auto"):
            raise ParameterError(f"partial must be True, False or 'auto', got {self.partial!r}")

    def check_code(self) -> None:
        """Raise `ParameterError` in a process whose package is not that which asks."""
        if self.code != code_digest():
            raise ParameterError(
                "this worker runs another version of qgeo_filters than the process that sends it work: install the "
                "same version everywhere"
            )

    def shape_key(self, surface: str) -> str:
        """Key of a prepared shape, by that of its surface."""
        return _key("shape", FORMAT, self.code, surface, asdict(self.parameters), self.repair)

    @property
    def how(self) -> str:
        """Key of what a match depends on besides its two shapes."""
        return _key("match", FORMAT, self.normalize, self.partial, self.mirror)[:12]

    def to_json(self) -> dict[str, Any]:
        """What `from_json` needs: of the parameters, those that are not the default."""
        usual = MatchingParameters()
        chosen = {one.name: getattr(self.parameters, one.name) for one in fields(usual)}
        changed = {name: value for name, value in chosen.items() if value != getattr(usual, name)}
        options = {name: getattr(self, name) for name in _OPTIONS}
        return {**options, "parameters": {name: _plain(value) for name, value in changed.items()}}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Settings:
        """The settings that `to_json` wrote.

        Raises
        ------
        ParameterError
            A parameter that this version does not have.
        """
        try:
            changed = {name: _tuples(value) for name, value in content["parameters"].items()}
            return cls(MatchingParameters(**changed), **{name: content[name] for name in _OPTIONS})
        except (KeyError, TypeError, AttributeError) as error:
            raise ParameterError(f"settings of a collection that this version does not know: {error}") from error


_OPTIONS = ("normalize", "partial", "mirror", "repair")


def surface_key(surface: Surface) -> str:
    """Key of a mesh by its content: vertices and faces."""
    # Not `content_key`, which goes by pickles: machines with other versions of Python share a store.
    digest = hashlib.sha256(f"{surface.vertices.shape} {surface.faces.shape}".encode())
    digest.update(np.ascontiguousarray(surface.vertices, "<f8").data)
    digest.update(np.ascontiguousarray(surface.faces, "<i4").data)
    return digest.hexdigest()[:32]


def map_key(*maps: npt.NDArray[np.int64] | None) -> str:
    """Key of some maps by their content, None for one that is not there."""
    lists = [None if one is None else one.astype("<i8").tobytes() for one in maps]
    return _key("maps", *(None if one is None else hashlib.sha256(one).hexdigest() for one in lists))


def _key(*parts: Any) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]


def _plain(value: Any) -> Any:
    if isinstance(value, Stage):
        return asdict(value)
    return [_plain(one) for one in value] if isinstance(value, tuple) else value


def _tuples(value: Any) -> Any:
    """Lists of JSON as tuples, mappings as stages of the registration."""
    if isinstance(value, dict):
        return Stage(**{name: _tuples(one) for name, one in value.items()})
    return tuple(_tuples(one) for one in value) if isinstance(value, list) else value
