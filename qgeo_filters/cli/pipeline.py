"""``qgeo run``: a saved pipeline of filters over meshes."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import (
    Also,
    Force,
    Json,
    Output,
    Pictures,
    Quiet,
    Repair,
    Settings,
    Workers,
    Wrap,
    repair_option,
)

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters._typing import RepairOption
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.base import Pipeline
    from qgeo_filters.report.shown import Shown
    from qgeo_filters.surface import Surface


def run(
    pipeline: Annotated[
        Path, typer.Argument(metavar="PIPELINE.yaml", help="Filters, as Pipeline.save writes them.", show_default=False)
    ],
    meshes: Annotated[
        list[Path],
        typer.Argument(metavar="MESH...", help="One mesh or more, or folders of them.", show_default=False),
    ],
    workers: Workers = None,
    cache: Cache = True,
    output: Output = None,
    repair: Repair = None,
    force: Force = False,
    wrap: Wrap = False,
    pictures: Pictures = True,
    also: Also = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a pipeline of filters over meshes; with several meshes, or a folder, each has its own folder in DIR.

    A mesh that cannot be read, or computed, is named, and the rest goes on; the exit code is then 1. A pipeline that is
    wrong is said before.

    result.npz: one array for each attribute that the filters add.
    """
    from qgeo_filters.cli.in_turn import in_turn
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.base import Pipeline

    steps = Pipeline.load(pipeline)
    mend = repair_option(repair, force, wrap)
    settings = Settings(output, quiet, json, mend, pictures, also)
    numbered = enumerate(steps.steps, start=1)
    parameters = {
        "pipeline": str(pipeline),
        **{f"{position}. {type(step).__name__}": step.get_params() for position, step in numbered},
        "repair": mend,
    }

    def one(mesh: Path, settings: Settings) -> None:
        names = [pipeline.stem, mesh.stem]
        job = Job("run", settings, parameters, [mesh], inputs=[pipeline], pictures=steps.outputs, about=names)
        (surface,) = job.read_given()
        _run_one(job, steps, surface, mend)

    in_turn(meshes, settings, one, "run", pipeline.stem)


def _run_one(job: Job, steps: Pipeline, surface: Surface, mend: RepairOption) -> None:
    import numpy as np

    from qgeo_filters.report.figures import plot_attribute

    with job.stage("pipeline"):
        described = steps(surface, repair=mend)
        if steps.repair_ is not None:
            job.repaired(0, steps.repair_.report)
    added = {name: np.asarray(values) for name, values in described.attributes.items() if name in steps.outputs}
    results = {name: _summary(values) for name, values in added.items()}
    job.save(results, added, described, shown=[None if "colors" in added or not added else _shown(added)])
    for name, values in added.items():
        draw = partial(plot_attribute, surface, name, values, images=name in steps.index_outputs)
        job.picture(name, f"{name}: {steps.outputs[name]}", draw)
    job.finish()


def _shown(added: dict[str, np.ndarray]) -> Shown:
    """The last attribute, of one column if there is such."""
    from qgeo_filters.report.shown import Shown

    one_column = [values for values in added.values() if values.ndim == 1]
    return Shown.of_attribute((one_column or list(added.values()))[-1])


def _summary(values: np.ndarray) -> dict[str, object]:
    """Shape and range of an attribute."""
    import numpy as np

    finite = np.asarray(values, dtype=np.float64)
    finite = finite[np.isfinite(finite)]
    return {
        "shape": list(values.shape),
        "min": float(finite.min()) if finite.size else None,
        "max": float(finite.max()) if finite.size else None,
        "not_finite": int(values.size - finite.size),
    }
