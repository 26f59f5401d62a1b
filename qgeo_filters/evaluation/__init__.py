"""Errors of maps against the truth, tables of them, and readers of the public data sets."""

from qgeo_filters.evaluation.benchmarks import BENCHMARKS, Benchmark, Published
from qgeo_filters.evaluation.datasets import Dataset, NoTruthError, PointMap, read_vts
from qgeo_filters.evaluation.download import SOURCES, Source, fetch
from qgeo_filters.evaluation.errors import (
    ErrorSummary,
    SymmetricErrors,
    area_under_curve,
    error_curve,
    geodesic_error,
    mirrored,
    symmetric_errors,
)
from qgeo_filters.evaluation.pair_datasets import PartialDataset, Shrec19, TopKids
from qgeo_filters.evaluation.processes import measured_in_processes
from qgeo_filters.evaluation.retrieval import Retrieval, retrieval_scores
from qgeo_filters.evaluation.runner import PairFailure, PairStore, by_target, measured
from qgeo_filters.evaluation.tables import PairResult, Row, markdown, rows_by_category
from qgeo_filters.evaluation.template_datasets import Dt4d, SplitDataset, VtsDataset
from qgeo_filters.evaluation.tosca_datasets import IndexedDataset, ToscaLowres, ToscaRemeshed

__all__ = [
    "BENCHMARKS",
    "SOURCES",
    "Benchmark",
    "Dataset",
    "Dt4d",
    "ErrorSummary",
    "IndexedDataset",
    "NoTruthError",
    "PairFailure",
    "PairResult",
    "PairStore",
    "PartialDataset",
    "PointMap",
    "Published",
    "Retrieval",
    "Row",
    "Shrec19",
    "Source",
    "SplitDataset",
    "SymmetricErrors",
    "TopKids",
    "ToscaLowres",
    "ToscaRemeshed",
    "VtsDataset",
    "area_under_curve",
    "by_target",
    "error_curve",
    "fetch",
    "geodesic_error",
    "markdown",
    "measured",
    "measured_in_processes",
    "mirrored",
    "read_vts",
    "retrieval_scores",
    "rows_by_category",
    "symmetric_errors",
]
