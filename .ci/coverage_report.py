"""Prints how much of the package's Python the last test run entered (branches too), and the files below 90 %.

Kernels are compiled by Numba and cannot be traced; pyproject.toml leaves them out.
"""

import io
import json
import tempfile
from pathlib import Path

from coverage import Coverage

LOOKED_AT = 90.0  # per cent; a file below it is looked at, nothing fails


def main() -> None:
    coverage = Coverage()
    coverage.load()
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "coverage.json")
        total = coverage.json_report(outfile=str(target))
        files = json.loads(target.read_text(encoding="utf-8"))["files"]
    print(f"\nbranch coverage of qgeo_filters: {total:.1f} %")
    shares = {name: file["summary"]["percent_covered"] for name, file in files.items()}
    for name, share in sorted(shares.items(), key=lambda item: item[1]):
        if share < LOOKED_AT:
            print(f"  {share:5.1f} %  {name}  lines {_ranges(files[name]['missing_lines'])}")


def _ranges(lines: list[int]) -> str:
    """12-15, 20: consecutive lines together."""
    if not lines:
        return "none: branches only"
    text = io.StringIO()
    for before, line, after in zip([-1, *lines[:-1]], lines, [*lines[1:], -1], strict=True):
        if line != before + 1:
            text.write(f"{', ' if text.tell() else ''}{line}")
        if line != before + 1 and line == after - 1:
            text.write("-")
        elif line == before + 1 and line != after - 1:
            text.write(str(line))
    return text.getvalue()


if __name__ == "__main__":
    main()
