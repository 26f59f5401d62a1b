"""A long run by hand: ``python -m fuzz.run --seconds 600 --seed 3 mat ply``, in the folder ``tests``.

Prints each kind of fault once, with the number of its inputs, and keeps the first input of each kind in a folder.
"""

from __future__ import annotations

import argparse
import re
from collections import Counter
from pathlib import Path

from fuzz.sandbox import files_of, fuzzed, timed_indices
from fuzz.targets import TARGETS


def main() -> None:
    """Run the targets one after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", help=f"of {', '.join(TARGETS)}; by default all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=60.0, help="for each target")
    parser.add_argument("--keep", type=Path, help="folder for inputs that fail")
    options = parser.parse_args()
    for target in options.targets or TARGETS:
        kinds: Counter[str] = Counter()
        count = 0
        for batch in timed_indices(options.seconds):
            for finding in fuzzed(target, options.seed, batch):
                kind = kind_of(finding.fault)
                if not kinds[kind]:
                    print(f"{target} {finding.index}: {finding.fault}", flush=True)
                    if options.keep:
                        keep(options.keep / f"{target}-{finding.index}", options.seed, target, finding.index)
                kinds[kind] += 1
            count += len(batch)
        print(f"{target}: {sum(kinds.values())} of {count} inputs fail, in {len(kinds)} kinds", flush=True)


def kind_of(fault: str) -> str:
    """The fault without what it quotes of the input: the exception and its place, else how it begins."""
    name, _, _ = fault.partition(":")
    where = re.search(r"\[[^\]]*\]$", fault)
    return f"{name} {where.group()}" if where else fault[:40]


def keep(folder: Path, seed: int, target: str, index: int) -> None:
    """Write the files of an input."""
    files, repair = files_of(target, seed, index)
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (folder / "repair").write_text(str(repair))


if __name__ == "__main__":
    main()
