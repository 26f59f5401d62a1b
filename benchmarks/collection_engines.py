"""All pairs within categories of TOSCA: in processes, then on a Dask cluster whose workers are killed; equal or not.

    python benchmarks/collection_engines.py ROOT STORES --categories wolf centaur dog [--kills 2] [--json FILE]

ROOT as for ``matching.py``, all categories by default. STORES is a folder for plain.zarr and cluster.zarr, which are
gone on with where they are there. The cluster is a LocalCluster of two processes of one thread; after each third of the
pairs a worker is killed (SIGKILL), so often as --kills says. Printed: wall and CPU seconds of the maps, mean error by
category (direct, over sqrt(area)), and whether the two tables are equal bit for bit.
"""

from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from pathlib import Path

import pandas as pd
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed


def built(data: ToscaRemeshed, names: list[str], store: Path) -> qg.Collection:
    """The collection of these shapes."""
    return qg.Collection({name: data.read(name) for name in names}, store, groups=data.category)


def on_cluster(collection: qg.Collection, kills: int, count: int) -> int:
    """Match on a cluster, workers killed meanwhile; how many were."""
    from dask.distributed import LocalCluster

    killed: list[int] = []
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local:

        def kill() -> None:
            for number in range(kills):
                while len(list((collection.store.root / "pairs").glob("*/*/*/zarr.json"))) < (number + 1) * count // 3:
                    time.sleep(0.2)
                alive = [nanny.pid for nanny in local.workers.values() if nanny.pid and nanny.pid not in killed]
                os.kill(alive[0], signal.SIGKILL)
                killed.append(alive[0])
                print(f"worker {alive[0]} killed", flush=True)

        threading.Thread(target=kill, daemon=True).start()
        collection.match("within groups", scheduler=local.scheduler_address, progress=True)
    return len(killed)


def main(record: Record) -> None:
    """Run both, and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("stores", type=Path)
    parser.add_argument("--categories", nargs="+")
    parser.add_argument("--kills", type=int, default=2)
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    names = [name for name in data.names() if not arguments.categories or data.category(name) in arguments.categories]
    arguments.stores.mkdir(parents=True, exist_ok=True)
    print(machine())
    started = time.perf_counter()
    plain = built(data, names, arguments.stores / "plain.zarr").match("within groups", progress=True)
    middle = time.perf_counter()
    cluster = built(data, names, arguments.stores / "cluster.zarr")
    killed = on_cluster(cluster, arguments.kills, len(plain.table()))
    ended = time.perf_counter()
    one, other = plain.table(), cluster.table()
    pd.testing.assert_frame_equal(one, other, check_exact=True)
    seconds = plain.table(seconds=True)["seconds"].sum()
    record.note(
        f"{len(names)} shapes, {len(one)} pairs: equal bit for bit, {killed} workers killed. Seconds of the clock: "
        f"{middle - started:.0f} in processes, {ended - middle:.0f} on the cluster; CPU seconds of "
        f"the maps: {seconds:.0f}."
    )

    def truth(x: str, y: str) -> object:
        known = data.truth(x, y)
        return known.images if len(known.points) == plain.surface(x).n_vertices else None

    found = plain.table(truth)
    table = record.table("", "category", "pairs", "mean error", "worst", "sure", align="lrrrr")
    for category, rows in found.groupby("group_x"):
        errors = (f"{rows['error'].mean():.4f}", f"{rows['error'].max():.4f}")
        table.row(category, len(rows), *errors, int(rows["confident"].sum()))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
