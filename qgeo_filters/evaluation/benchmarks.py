"""The public benchmarks of correspondence: how each is read, the pairs that the field takes, and published errors."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from qgeo_filters.evaluation.datasets import Dataset
from qgeo_filters.evaluation.pair_datasets import PartialDataset, Shrec19, TopKids
from qgeo_filters.evaluation.template_datasets import Dt4d, SplitDataset, VtsDataset
from qgeo_filters.evaluation.tosca_datasets import IndexedDataset, ToscaRemeshed

ZOOMOUT = "ZoomOut (Melzi et al., SIGGRAPH Asia 2019), from its own start"
BCICP = "BCICP (Ren et al., SIGGRAPH Asia 2018)"
SHELLS = "Smooth Shells (Eisenberger et al., CVPR 2020)"
SNK = "SNK (Attaiki and Ovsjanikov, NeurIPS 2023), aligned shapes"
DIFFUMATCH = "DiffuMatch (Pierson et al., 2025), aligned shapes"
LEARNED = "best trained network, 2023 to 2026 (ULRSSM, hybrid functional maps and their successors), aligned shapes"


@dataclass(frozen=True)
class Published:
    """A figure that others have published.

    Attributes
    ----------
    method : str
        And where it was published.
    error : float
        Mean geodesic error over sqrt(area), times 100.
    learned : bool
        Whether the method was trained on shapes of the same set.
    """

    method: str
    error: float
    learned: bool = False

    @property
    def short_name(self) -> str:
        """The method alone, without where it was published."""
        return re.split(r", | \(", self.method)[0]


@dataclass(frozen=True)
class Benchmark:
    """A public set.

    Attributes
    ----------
    title : str
    read : callable
        Takes the folder, returns the data set with its test pairs.
    partial : bool
        Whether parts are matched to wholes.
    published : tuple of Published
    """

    title: str
    read: Callable[[Path], Dataset]
    partial: bool = False
    published: tuple[Published, ...] = ()


def _published(*errors: tuple[str, float]) -> tuple[Published, ...]:
    return tuple(Published(method, error, learned=method == LEARNED) for method, error in errors)


#: By the name that the command line knows it by. Shapes from the first test shape on are taken, where it is there; all
#: shapes of a folder that holds others.
BENCHMARKS: dict[str, Benchmark] = {
    "tosca": Benchmark("TOSCA, every pose remeshed independently", ToscaRemeshed),
    "faust_r": Benchmark(
        "FAUST remeshed, the last 20 of 100 shapes, both directions",
        partial(SplitDataset, first="tr_reg_080"),
        published=_published(
            (ZOOMOUT, 6.1), (BCICP, 6.1), (SHELLS, 2.5), (SNK, 1.8), (DIFFUMATCH, 1.9), (LEARNED, 1.4)
        ),
    ),
    "scape_r": Benchmark(
        "SCAPE remeshed, the last 20 of 71 shapes, both directions",
        partial(SplitDataset, first="mesh052"),
        published=_published(
            (ZOOMOUT, 7.5), (BCICP, 11.0), (SHELLS, 4.7), (SNK, 4.7), (DIFFUMATCH, 4.4), (LEARNED, 1.8)
        ),
    ),
    "shrec19_r": Benchmark(
        "SHREC'19 humans remeshed, the pairs of the track",
        lambda root: Shrec19(root) if (root / "groundtruth").is_dir() else SplitDataset(root, ordered=False),
        published=_published((ZOOMOUT, 2.9), (BCICP, 3.0), (SNK, 5.8), (DIFFUMATCH, 3.9), (LEARNED, 3.1)),
    ),
    "smal_r": Benchmark(
        "SMAL remeshed: animals of different species, both directions",
        SplitDataset,
        published=_published((ZOOMOUT, 38.4), (SHELLS, 36.1), (SNK, 9.1), (DIFFUMATCH, 10.1), (LEARNED, 2.5)),
    ),
    "dt4d": Benchmark(
        "DeformingThings4D, pairs within a class",
        Dt4d,
        published=_published((ZOOMOUT, 4.0), (SNK, 2.0), (DIFFUMATCH, 1.8), (LEARNED, 0.9)),
    ),
    "topkids": Benchmark(
        "TOPKIDS: a child whose hands and arms are glued to the body",
        TopKids,
        published=_published((SHELLS, 11.8), (LEARNED, 3.3)),
    ),
    "shrec16_cuts": Benchmark(
        "SHREC'16 partial, cuts",
        partial(PartialDataset, kind="cuts"),
        partial=True,
        published=_published((LEARNED, 2.0)),
    ),
    "shrec16_holes": Benchmark(
        "SHREC'16 partial, holes",
        partial(PartialDataset, kind="holes"),
        partial=True,
        published=_published((LEARNED, 8.2)),
    ),
    "pfarm": Benchmark("PFARM: cuts of people onto a whole body", PartialDataset, partial=True),
    "kids": Benchmark("KIDS: two children", VtsDataset),
    "tosca_nonisometric": Benchmark(
        "TOSCA, gorilla, man and woman remeshed", VtsDataset, published=_published((BCICP, 15.8))
    ),
    "teeth": Benchmark("Lemur molars of both jaws, landmarks set by hand", VtsDataset),
    "indexed": Benchmark("Shapes of equal vertex numbers", IndexedDataset),
    "vts": Benchmark("Shapes that share a template", VtsDataset),
    "shrec19": Benchmark("SHREC'19 humans, the pairs of the track", Shrec19),
}
