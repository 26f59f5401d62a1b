"""What every host test compares: a shape and attributes of each kind, and their copies."""

from __future__ import annotations

import numpy as np
from shapes import blob

VERTICES, FACES = blob(2)
N, M = len(VERTICES), len(FACES)

_random = np.random.default_rng(3)
ATTRIBUTES = {
    "qgeo_scalar": _random.normal(size=N),
    "qgeo_index": np.arange(N)[::-1].copy(),
    "qgeo_vector": _random.normal(size=(N, 3)),
    "qgeo_wide": _random.normal(size=(N, 12)),
    "qgeo_mask": _random.random(N) > 0.5,
    "qgeo_single": _random.normal(size=N).astype(np.float32),
}
for _values in ATTRIBUTES.values():
    _values.setflags(write=False)


def assert_attributes(surface, expected, exact_dtype=True):
    """All expected attributes are there, bit by bit."""
    for name, values in expected.items():
        found = surface.attributes[name]
        assert found.shape == values.shape, name
        if exact_dtype:
            assert found.dtype == values.dtype, name
        np.testing.assert_array_equal(found, values, err_msg=name)
