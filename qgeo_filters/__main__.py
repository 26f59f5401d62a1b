"""``python -m qgeo_filters``: the same as ``qgeo``."""

from __future__ import annotations

from qgeo_filters.cli import main

if __name__ == "__main__":
    main()
