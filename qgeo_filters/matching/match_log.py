"""What `match` and `self_symmetry` looked at: every map proposed, what it cost, and which rule dropped it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

from qgeo_filters.html_repr import card

#: What an entry says of a map that is still in the race.
IN_THE_RACE = "in the race"
CHOSEN = "chosen"


@dataclass
class LoggedMap:
    """A map that was proposed.

    Attributes
    ----------
    number : int
        In the order of proposal, from 0.
    proposed_by : str
        Which part of the search, in which metric, or of which map it is the mirrored one.
    mean_distortion : float
        Mean |d_X(p, q) - d_Y(Tp, Tq)| in units of sqrt(area), as last measured.
    orientation : float, optional
        See `orientation`.
    strain, torn, folded, hks_agreement, relief_agreement : float, optional
        Terms of the cost as last measured, see `Contender`; None where the map was not deformed.
    preview_cost, end_cost : float, optional
        What the map cost after its preview, and where its registration ended.
    fate : str
        `CHOSEN`, or the rule that dropped it, in words.
    """

    number: int
    proposed_by: str
    mean_distortion: float
    orientation: float | None = None
    strain: float | None = None
    torn: float | None = None
    folded: float | None = None
    hks_agreement: float | None = None
    relief_agreement: float | None = None
    preview_cost: float | None = None
    end_cost: float | None = None
    fate: str = IN_THE_RACE


class MatchLog:
    """Maps in the order of their proposal; ``print(log)`` is a table, ``log.table()`` rows for a data frame.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> found, log = qg.match(x, x.with_vertices(2 * x.vertices), log=True)
    >>> print(str(log).splitlines()[0])
    | number | proposed_by | mean_distortion | orientation | strain | torn | folded | hks_agreement | ...
    """

    def __init__(self) -> None:
        self.maps: list[LoggedMap] = []

    def __len__(self) -> int:
        return len(self.maps)

    def __iter__(self) -> Iterator[LoggedMap]:
        return iter(self.maps)

    def __getitem__(self, number: int) -> LoggedMap:
        return self.maps[number]

    def propose(self, proposed_by: str, distortion: float, orientation: float | None = None) -> int:
        """Number of a new map."""
        self.maps.append(LoggedMap(len(self.maps), proposed_by, distortion, orientation))
        return len(self.maps) - 1

    def note(self, number: int, **values: float) -> None:
        """Set what was measured of a map; one whose cost at the end is known is in the race again."""
        entry = self.maps[number]
        for name, value in values.items():
            setattr(entry, name, value)
        if "end_cost" in values and entry.fate != CHOSEN:
            entry.fate = IN_THE_RACE

    def drop(self, number: int, rule: str) -> None:
        """Say which rule ended a map; the first one stands."""
        entry = self.maps[number]
        if entry.fate == IN_THE_RACE:
            entry.fate = rule

    def choose(self, number: int) -> None:
        """Say that this map was chosen; all others that are left cost more, an earlier choice included."""
        for entry in self.maps:
            if entry.fate == CHOSEN:
                entry.fate = IN_THE_RACE
        self.maps[number].fate = CHOSEN
        for entry in self.maps:
            self.drop(entry.number, f"costs more at the end than #{number}")

    @property
    def chosen(self) -> LoggedMap | None:
        """The map that was chosen, if any was."""
        return next((entry for entry in self.maps if entry.fate == CHOSEN), None)

    def table(self) -> list[dict[str, object]]:
        """One mapping for each map, with the fields of `LoggedMap`: what ``pandas.DataFrame`` takes."""
        return [{field.name: getattr(entry, field.name) for field in fields(LoggedMap)} for entry in self.maps]

    def __str__(self) -> str:
        """The table in Markdown, cheapest at the end first, then by preview, then by distortion."""
        names = [field.name for field in fields(LoggedMap)]
        rows = ["| " + " | ".join(names) + " |", "| ---: | --- |" + " ---: |" * (len(names) - 3) + " --- |"]
        rows += ["| " + " | ".join(_cell(getattr(entry, name)) for name in names) + " |" for entry in self.ranked()]
        return "\n".join(rows)

    def __repr__(self) -> str:
        return f"MatchLog({len(self.maps)} maps, chosen: {self.chosen.number if self.chosen else None})"

    def _repr_html_(self) -> str:
        rows = [
            (f"#{entry.number}", entry.proposed_by, entry.mean_distortion, _cell(entry.end_cost), entry.fate)
            for entry in self.ranked()
        ]
        columns = ("map", "proposed by", "mean distortion", "cost at the end", "fate")
        return card(f"MatchLog: {len(self)} maps", {}, table=rows, columns=columns)

    def ranked(self) -> list[LoggedMap]:
        """The chosen map, then those by how far they came and what they cost."""

        def key(entry: LoggedMap) -> tuple[int, float]:
            if entry.fate == CHOSEN:
                return 0, 0.0
            if entry.end_cost is not None:
                return 1, entry.end_cost
            return (2, entry.preview_cost) if entry.preview_cost is not None else (3, entry.mean_distortion)

        return sorted(self.maps, key=key)


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
