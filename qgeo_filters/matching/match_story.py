"""What a match tells of itself in a few lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from qgeo_filters.html_repr import card, histogram, shown

if TYPE_CHECKING:
    from qgeo_filters.matching.match_result import MatchResult


def story(found: MatchResult) -> str:
    """Sizes, whether the map can be trusted and why, how it distorts, and who is without partner."""
    lines = [
        f"MatchResult: {found.x.n_vertices} vertices of X on {found.y.n_vertices} of Y",
        f"  {'confident' if found.confident else 'NOT CONFIDENT'}: {found.explanation}",
        f"  distortion {found.score:.4f} sqrt(area) in the mean, {_largest(found.distortion):.4f} at most; "
        f"{_rivals(found)}",
        f"  orientation {found.orientation:.2f}, heat kernels agree to {found.hks_agreement:.2f}",
    ]
    lines += [f"  repaired: {sentence}" for sentence in found.repairs]
    shares = {"X": np.mean(found.p2p < 0), "Y": np.mean(found.inverse < 0)}
    without = [f"{100 * share:.1f} % of the vertices of {name}" for name, share in shares.items() if share]
    if without:
        lines.append(f"  no partner: {' and '.join(without)}")
    if found.repairs:
        many = "s" * (len(found.repairs) > 1)
        lines.append(f"  repaired before: {len(found.repairs)} change{many}, see repairs")
    return "\n".join(lines)


def html_story(found: MatchResult) -> str:
    """The same for a notebook, with the distortion over the area."""
    without = {"X": int(np.sum(found.p2p < 0)), "Y": int(np.sum(found.inverse < 0))}
    facts = {
        "mean distortion": f"{shown(found.score)} sqrt(area)",
        "largest distortion": f"{shown(_largest(found.distortion))} sqrt(area)",
        "other maps": _rivals(found),
        "orientation": found.orientation,
        "heat kernels agree to": found.hks_agreement,
        "C_XY": found.c_xy,
        "without partner": ", ".join(f"{count} vertices of {name}" for name, count in without.items() if count) or None,
        "repaired": list(found.repairs) or None,
        "landmarks missed by": None
        if not len(found.landmark_errors)
        else f"{shown(float(np.max(found.landmark_errors)))} sqrt(area) at most",
    }
    return card(
        f"MatchResult: {found.x.n_vertices} vertices of X on {found.y.n_vertices} of Y",
        facts,
        subtitle=f"{'confident' if found.confident else 'NOT CONFIDENT'}: {found.explanation}",
        bars=histogram(found.distortion, found.x.vertex_areas),
        bars_label=f"area of X by distortion, from 0 to {shown(_largest(found.distortion))} sqrt(area)",
    )


def _largest(distortion: np.ndarray) -> float:
    known = distortion[np.isfinite(distortion)]
    return float(known.max()) if known.size else np.nan


def _rivals(found: MatchResult) -> str:
    if not np.isfinite(found.runner_up):
        return "no other map was proposed"
    return f"the best other map: {found.runner_up:.4f}, at {found.margin:.2f} times the cost"
