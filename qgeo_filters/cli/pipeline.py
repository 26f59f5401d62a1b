"""``qgeo run``: a saved pipeline of filters over meshes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from qgeo_filters.cli.options import Force, Json, Output, Pictures, Quiet, Repair, Settings, Workers, repair_option

if TYPE_CHECKING:
    import numpy as np


def run(
    pipeline: Annotated[
        Path, typer.Argument(metavar="PIPELINE.yaml", help="Filters, as Pipeline.save writes them.", show_default=False)
    ],
    meshes: Annotated[list[Path], typer.Argument(metavar="MESH...", help="One mesh or more.", show_default=False)],
    workers: Workers = None,
    output: Output = None,
    repair: Repair = None,
    force: Force = False,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a pipeline of filters over meshes; with several meshes each has its own folder in DIR.

    result.npz: one array for each attribute that the filters add.
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.base import Pipeline
    from qgeo_filters.report.figures import plot_attribute

    steps = Pipeline.load(pipeline)
    mend = repair_option(repair, force)
    settings = Settings(output, quiet, json, mend, pictures)
    numbered = enumerate(steps.steps, start=1)
    parameters = {
        "pipeline": str(pipeline),
        **{f"{position}. {type(step).__name__}": step.get_params() for position, step in numbered},
        "repair": mend,
    }
    # All meshes are read before the first is computed: bad input shows at once.
    jobs = [
        Job(
            "run",
            replace(settings, output=folder),
            parameters,
            [mesh],
            inputs=[pipeline, *meshes],
            pictures=steps.outputs,
        )
        for folder, mesh in zip(_folders(settings.folder("run"), meshes), meshes, strict=True)
    ]
    surfaces = [job.read_given()[0] for job in jobs]
    for job, surface in zip(jobs, surfaces, strict=True):
        with job.stage("pipeline"):
            described = steps(surface, repair=mend, progress=job.progress)
            if steps.repair_ is not None:
                job.repaired(0, steps.repair_.report)
        added = {name: np.asarray(values) for name, values in described.attributes.items() if name in steps.outputs}
        job.save({name: _summary(values) for name, values in added.items()}, added, described)
        for name, values in added.items():
            draw = partial(plot_attribute, surface, name, values)
            job.picture(name, f"{name}: {steps.outputs[name]}", draw)
        job.finish()


def _folders(output: Path, meshes: list[Path]) -> list[Path]:
    """The folder itself for one mesh, else one below it for each mesh, numbered where names repeat."""
    if len(meshes) == 1:
        return [output]
    from qgeo_filters.cli.job import numbered

    return [output / name for name in numbered([mesh.stem for mesh in meshes])]


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
