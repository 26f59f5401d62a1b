"""``qgeo run``: a saved pipeline of filters over meshes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from qgeo_filters.cli.options import Force, Json, Output, Pictures, Quiet, Repair, Settings, Workers, repair_option
from qgeo_filters.errors import QgeoError, reason

if TYPE_CHECKING:
    import numpy as np

    from qgeo_filters._typing import RepairOption
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.base import Pipeline
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
    output: Output = None,
    repair: Repair = None,
    force: Force = False,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a pipeline of filters over meshes; with several meshes each has its own folder in DIR.

    Meshes that are named are all read before the first is computed: bad input shows at once. In a folder a mesh that
    cannot be read, or computed, is named, and the rest goes on; the exit code is then 1.

    result.npz: one array for each attribute that the filters add.
    """
    from qgeo_filters.cli.job import Job
    from qgeo_filters.filters.base import Pipeline
    from qgeo_filters.io.folders import mesh_files

    steps = Pipeline.load(pipeline)
    mend = repair_option(repair, force)
    settings = Settings(output, quiet, json, mend, pictures)
    numbered = enumerate(steps.steps, start=1)
    parameters = {
        "pipeline": str(pipeline),
        **{f"{position}. {type(step).__name__}": step.get_params() for position, step in numbered},
        "repair": mend,
    }
    patient = any(mesh.is_dir() for mesh in meshes)
    files = [file for mesh in meshes for file in mesh_files(mesh)] if patient else meshes
    bad = _Bad(patient)
    folders = _folders(settings.folder("run"), files, patient)
    # What a folder must not hold is said before any mesh is read.
    begun = [
        Job(
            "run",
            replace(settings, output=folder),
            parameters,
            [mesh],
            inputs=[pipeline, *files],
            pictures=steps.outputs,
        )
        for folder, mesh in zip(folders, files, strict=True)
    ]
    jobs = []
    for job in begun:
        with bad.named(job.paths[0], reading=True):
            jobs.append((job, job.read_given()[0]))
    for job, surface in jobs:
        with bad.named(job.paths[0]):
            _run_one(job, steps, surface, mend)
    if bad.files:
        typer.echo(f"qgeo: {bad.files} of {len(files)} meshes have no results", err=True)
        raise typer.Exit(1)


def _run_one(job: Job, steps: Pipeline, surface: Surface, mend: RepairOption) -> None:
    import numpy as np

    from qgeo_filters.report.figures import plot_attribute

    with job.stage("pipeline"):
        described = steps(surface, repair=mend, progress=job.progress)
        if steps.repair_ is not None:
            job.repaired(0, steps.repair_.report)
    added = {name: np.asarray(values) for name, values in described.attributes.items() if name in steps.outputs}
    job.save({name: _summary(values) for name, values in added.items()}, added, described)
    for name, values in added.items():
        draw = partial(plot_attribute, surface, name, values, images=name in steps.index_outputs)
        job.picture(name, f"{name}: {steps.outputs[name]}", draw)
    job.finish()


class _Bad:
    """Meshes that have no results: named where the rest goes on."""

    def __init__(self, patient: bool) -> None:
        self.patient, self.files = patient, 0

    @contextmanager
    def named(self, mesh: Path, *, reading: bool = False) -> Iterator[None]:
        """Context in which what is wrong with a mesh is said, or raised where the rest does not go on."""
        try:
            yield
        except (QgeoError, MemoryError, OSError) as error:
            if not self.patient or (isinstance(error, OSError) and not reading):  # a full disk ends it
                raise
            self.files += 1
            said = reason(error)
            typer.echo(f"qgeo: {said if str(mesh) in said else f'{mesh}: {said}'}", err=True)


def _folders(output: Path, meshes: list[Path], below: bool) -> list[Path]:
    """The folder itself for one mesh, else one below it for each mesh, numbered where names repeat."""
    if len(meshes) == 1 and not below:
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
