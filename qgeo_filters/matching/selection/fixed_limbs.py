"""Whether a reflection is another one with limbs left in place."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.candidates import between
from qgeo_filters.matching.prepared_shape import PreparedShape

# Images this far apart, in sqrt(area), are different; the least share of the area where they are.
_DIFFERENT, _LEAST_AREA = 0.2, 0.02
# There, one map moves points by less than this in the mean, the other by more than that, in sqrt(area).
_STAYS, _GOES = 0.15, 0.3
# Least share of it that the other map takes to itself: it exchanges limbs there.
_EXCHANGED = 0.7


def leaves_limbs(x: PreparedShape, one: IndexArray, other: IndexArray) -> bool:
    """Whether map ``one`` (n,) of a shape to itself is ``other``, but for limbs that it mirrors into themselves.

    Such a map is continuous, reverses the orientation and is an involution, too: it is the other one followed by a half
    turn of the surface between the two limbs, which exchanges them. And since a limb keeps its pose where it is, but
    two limbs seldom have the same, it may well distort distances less than the true reflection does.
    """
    here = np.arange(x.n_vertices)
    limbs = between(x, one, other) > _DIFFERENT
    weight = x.areas * limbs
    total = float(weight.sum())
    if total < _LEAST_AREA:
        return False
    stays, goes = (float(weight @ between(x, here, p2p)) / total for p2p in (one, other))
    return stays < _STAYS and goes > _GOES and float(weight @ limbs[other]) > _EXCHANGED * total
