"""Public data sets from where their authors, or the web archive, keep them."""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import Any

from qgeo_filters.errors import MeshError, ParameterError, of_file, require_package
from qgeo_filters.evaluation.datasets import Dataset
from qgeo_filters.evaluation.template_datasets import VtsDataset
from qgeo_filters.evaluation.tosca_datasets import IndexedDataset


@dataclass(frozen=True)
class Source:
    """A data set that can be downloaded.

    Attributes
    ----------
    urls : tuple of str
        Its zip archives.
    folders : mapping of str to str
        Where files go, by suffix, as `reader` expects them; others are left out.
    reader : callable
        Takes the folder, returns the `Dataset`.
    terms : str
        Who made it, and on what terms.
    hashes : mapping of str to str
        SHA-256 of archives, by URL, where it is known from a source other than the download itself.
    benchmark : str
        Name in `BENCHMARKS` of what is measured on it; by default the layout that the reader reads.
    """

    urls: tuple[str, ...]
    folders: Mapping[str, str]
    reader: Callable[[Path], Dataset]
    terms: str
    hashes: Mapping[str, str] = field(default_factory=dict)
    benchmark: str = ""


_LIX = "https://nuage.lix.polytechnique.fr/index.php/s/LJFXrsTG22wYCXx/download?path=%2F&files="
_HUMANS = {".off": "off", ".vts": "corres"}

#: Data sets by name. Nobody has published hashes of these archives, so there are none here.
SOURCES: Mapping[str, Source] = {
    # The authors' own server no longer answers; this is its file as it was.
    "tosca": Source(
        ("https://web.archive.org/web/20240118105018if_/http://tosca.cs.technion.ac.il/data/toscahires-asci.zip",),
        {".vert": ".", ".tri": "."},
        IndexedDataset,
        "Bronstein, Bronstein, Kimmel, Numerical Geometry of Non-Rigid Shapes, 2008; for academic use, not to be "
        "passed on",
    ),
    "faust-remeshed": Source(
        (f"{_LIX}FAUST_r.zip", f"{_LIX}FAUST_r_vts.zip"),
        _HUMANS,
        VtsDataset,
        "Bogo, Romero, Loper, Black, FAUST, CVPR 2014, remeshed by Ren et al. 2018; for research, on FAUST's terms",
        benchmark="faust_r",
    ),
    "scape-remeshed": Source(
        (f"{_LIX}SCAPE_r.zip", f"{_LIX}SCAPE_r_vts.zip"),
        _HUMANS,
        VtsDataset,
        "Anguelov et al., SCAPE, SIGGRAPH 2005, remeshed by Ren et al. 2018; for research",
        benchmark="scape_r",
    ),
    "horse-gallop": Source(
        ("https://people.csail.mit.edu/sumner/research/deftransfer/data/horse-gallop.zip",),
        {".obj": "."},
        IndexedDataset,
        "Sumner and Popovic, Deformation transfer for triangle meshes, SIGGRAPH 2004",
    ),
}

# Digests of the files of a data set as they were unpacked, in its folder.
_LISTING = ".unpacked.json"


def fetch(
    name: str,
    folder: str | PathLike[str] | None = None,
    *,
    known_hash: str | Mapping[str, str] | None = None,
    progress: bool = False,
) -> Dataset:
    """A public data set, downloaded when it is asked for first.

    **No archive of `SOURCES` has a published hash**: what comes is what the server sends. The SHA-256 of an archive
    that nothing was held against is told in a warning, to be passed as ``known_hash`` from then on.

    Parameters
    ----------
    name : str
        One of `SOURCES`: ``"tosca"`` (full resolution), ``"faust-remeshed"``, ``"scape-remeshed"``,
        ``"horse-gallop"``. Mind the terms of each.
    folder : path, optional
        Where data sets are kept, each in a folder of its name; the user's cache folder by default.
    known_hash : str, or mapping of str to str, optional
        SHA-256 of the archive, or of each by its URL.
    progress : bool
        Whether to show a progress bar.

    Returns
    -------
    Dataset

    Raises
    ------
    ValueError
        Unknown name; an archive that is not the one of the known hash; a folder of the data set's name that would be
        replaced and holds a file that was not unpacked into it, or was changed since.
    MeshError
        An archive without the expected files.
    OSError
        The server does not answer (ConnectionError), or the folder cannot be written.
    MissingPackageError
        Without pooch.
    """
    if name not in SOURCES:
        raise ParameterError(f"no data set {name!r}: there are {', '.join(SOURCES)}")
    source = SOURCES[name]
    if isinstance(known_hash, str):
        if len(source.urls) > 1:
            raise ParameterError(
                f"{name} comes in {len(source.urls)} archives: known_hash must give the hash of each URL"
            )
        known_hash = {source.urls[0]: known_hash}
    hashes = {**source.hashes, **(known_hash or {})}
    pooch = require_package("pooch", "download", "fetching a data set")
    requests = require_package("requests", "download", "fetching a data set")  # a dependency of pooch
    base = Path(pooch.os_cache("qgeo-filters") if folder is None else folder)
    archives = base / "archives"
    root = base / name
    places = {url: archives / f"{name}-{hashlib.sha256(url.encode()).hexdigest()[:8]}.zip" for url in source.urls}
    if not all(place.is_file() for place in places.values()):
        _require_own(root)  # before gigabytes are downloaded that could not be unpacked
    files = []
    for url, place in places.items():
        if url in hashes and place.is_file() and pooch.file_hash(str(place)) != hashes[url]:
            raise ParameterError(f"{place} does not match the known hash: move it away to download it again")
        try:
            with of_file(str(place)):
                file = Path(pooch.retrieve(url, hashes.get(url), place.name, archives, progressbar=progress))
        except requests.RequestException as error:
            raise ConnectionError(
                f"{url} cannot be downloaded, {_reason(error)}: check the network, or save the archive by other means "
                f"as {place.absolute()}"
            ) from error
        except ValueError as error:  # pooch's word for an archive that is another one
            raise ParameterError(str(error)) from error
        if url not in hashes:
            warnings.warn(
                f"{url} was not held against a known hash; its SHA-256 is {pooch.file_hash(str(file))}: give it as "
                "known_hash to be sure of it from now on",
                stacklevel=2,
            )
        files.append(file)
    newest = max(file.stat().st_mtime for file in files)
    if not root.is_dir() or root.stat().st_mtime < newest:
        _require_own(root)
        with of_file(str(root)):
            _unpack(files, root, source.folders)
    return source.reader(root)


def _reason(error: Any) -> str:
    """Why a request failed, in a few words; what requests says names its own insides."""
    return "no answer" if error.response is None else f"the server answers with status {error.response.status_code}"


def _require_own(root: Path) -> None:
    """Raise where the folder holds a file that was not unpacked into it, or was changed since."""
    try:
        unpacked = dict(json.loads((root / _LISTING).read_bytes()))
    except (FileNotFoundError, NotADirectoryError, ValueError, TypeError):
        unpacked = {}
    for path in sorted(root.rglob("*")):
        if (path.is_dir() and not path.is_symlink()) or path == root / _LISTING:
            continue
        if path.is_symlink() or unpacked.get(path.relative_to(root).as_posix()) != _digest(path):
            raise ParameterError(
                f"{root} is to be unpacked anew, but {path} is not as it came from an archive: choose another folder, "
                f"or move {root} away"
            )


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _unpack(archives: list[Path], root: Path, folders: Mapping[str, str]) -> None:
    """Put the files of these suffixes into their folders under root, all of them or none, and list their digests."""
    with tempfile.TemporaryDirectory(dir=root.parent, prefix=f".{root.name}-") as temporary:
        made = Path(temporary) / root.name
        made.mkdir()
        for archive in archives:
            _extract(archive, made, folders)
        digests = {path.relative_to(made).as_posix(): _digest(path) for path in made.rglob("*") if path.is_file()}
        (made / _LISTING).write_text(json.dumps(digests, indent=2) + "\n", encoding="utf-8")
        if root.is_dir():
            root.rename(Path(temporary) / "replaced")
        made.rename(root)


def _extract(archive: Path, made: Path, folders: Mapping[str, str]) -> None:
    """Put an archive's files of these suffixes into their folders."""
    count = 0
    try:
        with zipfile.ZipFile(archive) as content:
            for entry in content.infolist():
                path = PurePosixPath(entry.filename)
                # Archives made on a Mac have a shadow of each file.
                if entry.is_dir() or path.suffix.lower() not in folders or path.name.startswith("._"):
                    continue
                target = made / folders[path.suffix.lower()] / path.name
                if target.exists():
                    raise MeshError(f"{archive} holds more than one {path.name}")
                target.parent.mkdir(exist_ok=True)
                with content.open(entry) as read, target.open("wb") as write:
                    shutil.copyfileobj(read, write)
                count += 1
    except zipfile.BadZipFile as error:
        raise MeshError(f"{archive} is no zip archive: remove it to download it again") from error
    if not count:
        raise MeshError(f"{archive} holds no {' or '.join(folders)} files")
