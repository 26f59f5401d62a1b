"""Ends each file that is named with one newline; fails if one had to be changed, as pre-commit expects."""

import sys
from pathlib import Path


def main(names: list[str]) -> int:
    """How many files were changed."""
    changed = 0
    for name in names:
        content = Path(name).read_bytes()
        ended = content.rstrip(b"\r\n") + b"\n" if content.strip() else b""
        if content != ended:
            Path(name).write_bytes(ended)
            changed += 1
    return changed


if __name__ == "__main__":
    sys.exit(min(main(sys.argv[1:]), 1))
