"""Errors of maps against the truth, tables of them, and readers of the public data sets."""

from qgeo_filters.evaluation.datasets import (
    Dataset,
    IndexedDataset,
    PointMap,
    Shrec19,
    ToscaLowres,
    ToscaRemeshed,
    VtsDataset,
    read_vts,
)
from qgeo_filters.evaluation.download import fetch
from qgeo_filters.evaluation.errors import (
    ErrorSummary,
    SymmetricErrors,
    error_curve,
    geodesic_error,
    mirrored,
    symmetric_errors,
)
from qgeo_filters.evaluation.tables import PairResult, Row, markdown, rows_by_category

__all__ = [
    "Dataset",
    "ErrorSummary",
    "IndexedDataset",
    "PairResult",
    "PointMap",
    "Row",
    "Shrec19",
    "SymmetricErrors",
    "ToscaLowres",
    "ToscaRemeshed",
    "VtsDataset",
    "error_curve",
    "fetch",
    "geodesic_error",
    "markdown",
    "mirrored",
    "read_vts",
    "rows_by_category",
    "symmetric_errors",
]
