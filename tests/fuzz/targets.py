"""Readers of the package, each with good files that it reads and the ways in which these are changed."""

from __future__ import annotations

import contextlib
import functools
import io
import json
import os
import random
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import known_match
import numpy as np
import scipy.io
from fuzz import mutations
from fuzz.mutations import Mutation
from known_match import without_partners
from shapes import icosphere

import qgeo_filters as qg
from qgeo_filters.caching import StageCache
from qgeo_filters.cli.match import read_truth
from qgeo_filters.evaluation import PairResult, PairStore, SymmetricErrors, ToscaRemeshed, read_vts
from qgeo_filters.filters.base import Pipeline
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.surface import Surface

Files = Mapping[str, bytes]

V, F = icosphere(0)
SURFACE = Surface(V * np.pi, F)
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@dataclass(frozen=True)
class Target:
    """A reader and what it is tried on.

    Attributes
    ----------
    seeds : callable
        Folders of good files, by name.
    mutate : callable
    read : callable
        Takes a folder and whether to repair; raises, or returns what was read. An AssertionError is a fault.
    kept : str
        End of the names of files that are never changed.
    cost : int
        How often slower it is than most: so many times fewer inputs are tried in the gate.
    """

    seeds: Callable[[], list[Files]]
    mutate: Mutation
    read: Callable[[Path, bool], object]
    kept: str = "\0"
    cost: int = 1

    def input(self, rng: random.Random) -> dict[str, bytes]:
        """A folder in which one file was changed."""
        files = dict(rng.choice(self.seeds()))
        name = rng.choice([name for name in files if not name.endswith(self.kept)])
        files[name] = self.mutate(rng, files[name])
        return files


# -- meshes -------------------------------------------------------------------------------------------


def mesh(mutate: Mutation, seeds: Callable[[], list[Files]], cost: int = 1) -> Target:
    """Target of a mesh format: the first file is read."""

    def read(folder: Path, repair: bool) -> object:
        file = next(path for path in sorted(folder.iterdir()) if path.stem == "mesh" and path.suffix != ".bin")
        return Surface.read(file, repair=repair)

    return Target(functools.cache(seeds), mutate, read, cost=cost)


def written(suffix: str) -> Files:
    """Files that the package itself writes."""
    with TemporaryDirectory() as folder:
        surface = SURFACE if suffix != ".ply" else SURFACE.with_attributes({"f": V[:, 0], "long": F[:12].astype("i8")})
        surface.write(Path(folder) / f"mesh{suffix}")
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def rows(values: Any, before: str = "", after: str = "") -> str:
    """A line for each row of a table."""
    return "".join(f"{before}{' '.join(map(str, row))}{after}\n" for row in values)


def off_seeds() -> list[Files]:
    text = f"COFF # colours\n\n4 2 0\n{rows(SQUARE, after=' .5 0 0 1')}4 0 1 2 3 255 0 0\n3 0 1 2 # face\n"
    return [written(".off"), {"mesh.off": text.encode()}]


def obj_seeds() -> list[Files]:
    text = f"# square\nmtllib a.mtl\no part\n{rows(SQUARE, 'v ')}vt 0 0\nvt 1 0\nvn 0 0 1\ng a b\nusemtl c\ns off\n"
    text += "f 1/1/1 2/2/1 \\\n3//1\nf -4 -2 -1\nf 1 2 3 4\nl 1 2\n"
    return [written(".obj"), {"mesh.obj": text.encode()}]


def stl_seeds() -> list[Files]:
    facet = (
        "facet normal 0 0 1\n outer loop\n  vertex {} {} {}\n  vertex {} {} {}\n  vertex {} {} {}\n endloop\nendfacet\n"
    )
    corners = [facet.format(*map(float, V[face].ravel())) for face in F[:6]]
    return [written(".stl"), {"mesh.stl": f"solid x\n{''.join(corners)}endsolid x\n".encode()}]


def ply_seeds() -> list[Files]:
    head = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n"
    head += "property list uchar int vertex_indices\nproperty uchar flags\nend_header\n"
    text = head + rows(SQUARE, after=" 255 0 7") + "3 0 1 2 0\n4 0 1 2 3 1\n"
    strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    strips += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    strips += rows(SQUARE) + "6 0 1 3 2 -1 0\n"
    big = head.replace("ascii", "binary_big_endian").encode()
    big += np.array([(*point, 1, 2, 3) for point in SQUARE], ">f4, >f4, >f8, u1, u1, u1").tobytes()
    big += b"\3" + np.array([0, 1, 2], ">i4").tobytes() + b"\0\4" + np.array([0, 1, 2, 3], ">i4").tobytes() + b"\1"
    return [written(".ply"), {"mesh.ply": text.encode()}, {"mesh.ply": strips.encode()}, {"mesh.ply": big}]


def gltf_document() -> tuple[dict[str, Any], bytes]:
    """A glTF document and its buffer: an icosahedron with normals, under a node that is placed."""
    positions, indices = V.astype("<f4").tobytes(), F.astype("<u2").tobytes()
    views = [(0, len(positions)), (len(positions), len(indices))]
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "translation": [1, 0, 0]}, {"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(V), "type": "VEC3", "byteOffset": 0,
             "min": V.min(axis=0).tolist(), "max": V.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": 5123, "count": F.size, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": length} for start, length in views],
        "buffers": [{"byteLength": len(positions + indices)}],
    }, positions + indices  # fmt: skip


def gltf_seeds() -> list[Files]:
    document, buffer = gltf_document()
    document["buffers"][0]["uri"] = "mesh.bin"
    return [{"mesh.gltf": json.dumps(document).encode(), "mesh.bin": buffer}]


def mat_seeds() -> list[Files]:
    x, y, z = V.T[:, :, None]
    surface = {"X": x, "Y": y, "Z": z, "TRIV": F + 1.0}
    nested = {"surface": {"VERT": V, "TRIV": F + 1.0}, "evals": np.arange(4.0), "note": np.array(["a", 1], object)}
    found: list[Files] = [written(".mat")]
    for content, options in (
        ({"surface": surface}, {"do_compression": True}),
        ({"VERT": V, "TRIV": (F + 1).astype("i4"), "name": "cat"}, {}),
        ({"S": nested}, {}),
        ({"VERT": V, "TRIV": F + 1.0}, {"format": "4"}),
    ):  # fmt: skip
        out = io.BytesIO()
        scipy.io.savemat(out, content, **options)
        found.append({"mesh.mat": out.getvalue()})
    return found


def saved_by(*savers: tuple[str, Callable[[Path], object]]) -> list[Files]:
    """Files that other libraries write, by name; those of libraries that are not installed are left out."""
    found: list[Files] = []
    with TemporaryDirectory() as folder:
        for name, save in savers:
            with contextlib.suppress(ImportError):
                save(Path(folder) / name)
                found.append({name: (Path(folder) / name).read_bytes()})
    return found


def brain_seeds() -> list[Files]:
    def gifti(file: Path) -> None:
        from nibabel.gifti import GiftiDataArray, GiftiImage

        arrays = (
            (V.astype("f4"), "NIFTI_INTENT_POINTSET"),
            (F, "NIFTI_INTENT_TRIANGLE"),
            (V[:, 0], "NIFTI_INTENT_SHAPE"),
        )
        data = [
            GiftiDataArray(
                values.astype("f4" if values.dtype.kind == "f" else "i4"),
                intent,
                "NIFTI_TYPE_FLOAT32" if values.dtype.kind == "f" else "NIFTI_TYPE_INT32",
                encoding=encoding,
            )
            for (values, intent), encoding in zip(arrays, (3, 1, 2), strict=True)
        ]
        GiftiImage(darrays=data).to_filename(file)

    return saved_by(("mesh.gii", gifti))


def freesurfer_seeds() -> list[Files]:
    def save(file: Path) -> None:
        from nibabel.freesurfer import write_geometry

        write_geometry(file, V, F)

    return saved_by(("mesh.pial", save))


def vtk_seeds() -> list[Files]:
    def save(file: Path) -> None:
        import pyvista

        polydata = pyvista.PolyData.from_regular_faces(V, F)
        polydata.point_data["f"] = V[:, 0]
        polydata.save(file, binary=file.suffix == ".vtp")

    return saved_by(("mesh.vtk", save), ("mesh.vtp", save))


def gmsh_seeds() -> list[Files]:
    def save(file: Path) -> None:
        import meshio

        meshio.gmsh.write(file, meshio.Mesh(V, [("triangle", F)]), "2.2", binary=True)

    nodes = rows([(i + 1, *point) for i, point in enumerate(SQUARE)])
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n{nodes}$EndNodes\n$Elements\n2\n"
    text += "1 2 2 0 1 1 2 3\n2 3 2 0 1 1 2 3 4\n$EndElements\n"
    return [*saved_by(("mesh.msh", save)), {"mesh.msh": text.encode()}]


MESHES = {
    "off": mesh(mutations.text_changed, off_seeds),
    "obj": mesh(mutations.text_changed, obj_seeds),
    "stl": mesh(mutations.both_changed, stl_seeds),
    "ply": mesh(mutations.in_ply, ply_seeds),
    "glb": mesh(mutations.in_glb, lambda: [written(".glb")]),
    "gltf": mesh(
        lambda rng, content: (mutations.in_json if content[:1] == b"{" else mutations.bytes_changed)(rng, content),
        gltf_seeds,
    ),
    "mat": mesh(mutations.in_deflated_matrices, mat_seeds),
    "vert_tri": mesh(mutations.text_changed, lambda: [written(".vert")]),
    "gifti": mesh(mutations.both_changed, brain_seeds),
    "freesurfer": mesh(mutations.bytes_changed, freesurfer_seeds),
    "vtk": mesh(mutations.both_changed, vtk_seeds, cost=40),
    "gmsh": mesh(mutations.both_changed, gmsh_seeds, cost=40),
}


# -- maps and truths ----------------------------------------------------------------------------------


def saved(**arrays: Any) -> bytes:
    """Content of an .npz file."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def saved_one(array: Any) -> bytes:
    """Content of an .npy file."""
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def read_tosca(folder: Path, repair: bool) -> object:
    """The true map of two poses, and the left/right map of one."""
    data = ToscaRemeshed(folder)
    for one in (data.truth("cat0", "cat1"), data.symmetry("cat0")):
        assert one.points.dtype == one.images.dtype == np.int64
        assert one.points.shape == one.images.shape
        assert (one.images >= 0).all()
    return data


def tosca_seeds() -> list[Files]:
    table = {"full_of_vertex": np.arange(12), "vertex_of_full": np.arange(20) % 12}
    files = {f"ground_truth/cat{i}.npz": saved(**table) for i in (0, 1)}
    files |= {f"remeshed/cat{i}.off": b"" for i in (0, 1)}
    return [{**files, "symmetry/cat.sym": rows([[20 - i] for i in range(20)]).encode()}]


def read_map(folder: Path, repair: bool) -> object:
    """True vertices, one for each vertex of X."""
    found = read_truth(next(folder.iterdir()), 12, 20)
    assert found.shape == (12,)
    assert ((found >= -1) & (found < 20)).all()
    return found


def map_seeds() -> list[Files]:
    values = np.arange(12)
    out = io.BytesIO()
    np.savez_compressed(out, truth=values, other=values)
    return [
        {"map.npz": saved(p2p=values, score=1.0)},
        {"map.npz": out.getvalue()},
        {"map.npy": saved_one(values)},
        {"map.txt": rows([[i] for i in values]).encode()},
    ]


def map_changed(rng: random.Random, content: bytes) -> bytes:
    """Another file of true vertices, whatever its kind."""
    if content[:2] == b"PK":
        return mutations.in_zip(mutations.in_npy)(rng, content)
    return (mutations.in_npy if content[:1] == b"\x93" else mutations.text_changed)(rng, content)


def read_indices(folder: Path, repair: bool) -> object:
    """Vertices of a correspondence table."""
    found = read_vts(folder / "a.vts")
    assert found.ndim == 1
    assert (found >= 0).all()
    return found


PAIR = PairResult("cat0 - cat1", "cat", SymmetricErrors(V[:, 0] ** 2, V[:, 1] ** 2), True, 2.5, np.arange(12))


def read_pair(folder: Path, repair: bool) -> object:
    """The kept result of a pair, or that there is none."""
    found = PairStore(folder).load(PAIR.name, PAIR.category, "key")
    if found is not None:
        assert found.errors.direct.dtype == found.errors.reflected.dtype == np.float64
        assert found.errors.direct.shape == found.errors.reflected.shape
        assert found.errors.direct.ndim == found.p2p.ndim == 1
        assert np.isfinite(found.errors.direct).all()
        assert found.p2p.dtype.kind == "i"
    return found


def pair_seeds() -> list[Files]:
    with TemporaryDirectory() as folder:
        PairStore(Path(folder)).save(PAIR, "key")
        return [{path.name: path.read_bytes() for path in Path(folder).iterdir()}]


MAPS = {
    "ground_truth": Target(functools.cache(tosca_seeds), map_changed, read_tosca, kept=".off"),
    "true_map": Target(functools.cache(map_seeds), map_changed, read_map),
    "vts": Target(lambda: [{"a.vts": rows([[3], [1], [12], [7]]).encode()}], mutations.text_changed, read_indices),
    "stored_pair": Target(functools.cache(pair_seeds), mutations.in_zip(mutations.in_npy), read_pair),
}


# -- landmarks and matches ----------------------------------------------------------------------------

MARKS = qg.Landmarks(["tip of the nose", "2", "ear, left"], [V[0], [np.nan] * 3, V[2]], [4, -1, 7], "RAS")
TABLE = "# by hand\nLabel;X (mm);Y (mm);Z (mm);vertex\ntip;1,5;-2;3,25;7\near;NA;NA;NA;-1\n"
TPS = "LM3=2\n1 2 3\nNA NA NA\nCURVES=1\nPOINTS3D=2\n1 1 1\n2 2 2\nIMAGE=a.ply\nID=0\nSCALE=.5\nLM3=1\n4 5 6\n"
FCSV = "# CoordinateSystem = 0\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
FCSV += '1,1.5,-2,3,0,0,0,1,1,1,0,"nose, tip",,\r,2,0\n2,0,0,0,0,0,0,1,1,1,0,F-2,,\r,0,0\n'
AMIRA = "# Avizo 3D ASCII 2.0\ndefine Markers 2\nParameters {\n NumSets 2,\n}\nMarkers { float[3] Coordinates } @1\n"
AMIRA += "Markers { float[3] Coordinates2 } @2\n@1\n1 2 3\n4 5 6\n\n@2\n1 1 1\n2 2 2\n"


def landmark_file(suffix: str, mutate: Mutation, *texts: str) -> Target:
    """Target of a format of landmarks: what the package writes, and what others do."""

    def seeds() -> list[Files]:
        with TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # names that are dropped
            qg.write_landmarks(Path(folder) / f"marks{suffix}", MARKS)
            own = (Path(folder) / f"marks{suffix}").read_bytes()
        return [{f"marks{suffix}": content} for content in (own, *(text.encode() for text in texts))]

    return Target(functools.cache(seeds), mutate, read_marks)


def read_marks(folder: Path, repair: bool) -> object:
    """Landmarks: the first set, or the only one."""
    found = qg.read_landmarks(next(folder.iterdir()), specimen=0)
    assert len(found.names) == len(found.points) == len(found.vertices) > 0
    assert found.points.dtype == np.float64
    assert not np.isinf(found.points).any()
    assert (np.isnan(found.points).any(axis=1) == np.isnan(found.points).all(axis=1)).all()
    assert (found.vertices >= -1).all()
    return found


def read_match(folder: Path, repair: bool) -> object:
    """A saved match, whose map is used."""
    found = qg.MatchResult.from_npz(folder / "match.npz")
    assert found.transfer(found.x.vertices).shape == (found.y.n_vertices, 3)
    assert len(found.transfer(np.arange(found.y.n_vertices), to="x")) == found.x.n_vertices
    assert repr(found)
    return found


def match_seeds() -> list[Files]:
    found = known_match.ellipsoids(1, 0)
    found.log.choose(found.log.propose("the search", 0.25))
    lost = without_partners(found, found.x.vertices[:, 2] < 0, found.y.vertices[:, 2] < 5)
    with TemporaryDirectory() as folder:
        for name, result in (("a", found), ("b", lost)):
            result.to_npz(Path(folder) / f"{name}.npz")
        return [{"match.npz": path.read_bytes()} for path in sorted(Path(folder).iterdir())]


LANDMARKS = {
    "landmarks_csv": landmark_file(".csv", mutations.text_changed, TABLE, "1 2 3\n4 5 6\n", "tip,4\n"),
    "landmarks_fcsv": landmark_file(".fcsv", mutations.text_changed, FCSV),
    "landmarks_json": landmark_file(".mrk.json", mutations.in_json),
    "landmarks_tps": landmark_file(".tps", mutations.text_changed, TPS),
    "landmarks_pts": landmark_file(".pts", mutations.text_changed, "2\n1 2 3\n4 5 6\n"),
    "landmarks_amira": landmark_file(".landmarkAscii", mutations.text_changed, AMIRA),
    "landmarks_pp": landmark_file(".pp", mutations.text_changed),
    "match": Target(functools.cache(match_seeds), mutations.in_zip(mutations.in_npy), read_match),
}


# -- distances, pipelines, kept stages ----------------------------------------------------------------


@functools.cache
def matrix() -> np.ndarray:
    """All distances of the surface."""
    return np.asarray(distance_matrix(SURFACE, workers=1))


def zarr_seeds() -> list[Files]:
    with TemporaryDirectory() as folder:
        root = Path(folder) / "d.zarr"
        distance_matrix(SURFACE, out=root, workers=1)
        whole = {path.relative_to(folder).as_posix(): path.read_bytes() for path in root.rglob("*") if path.is_file()}
    begun = dict(whole)
    document = json.loads(begun["d.zarr/zarr.json"])
    document["attributes"]["qgeo_distance_matrix"]["done"] = "00"
    begun["d.zarr/zarr.json"] = json.dumps(document).encode()
    return [whole, begun]


def zarr_changed(rng: random.Random, content: bytes) -> bytes:
    """Another description of the array; of a row only its length, as nothing says what numbers are right."""
    if content[:1] == b"{":
        return mutations.in_json(rng, content)
    return rng.choice((b"", content[:-1], content[: len(content) // 2], content + content))


def read_zarr(folder: Path, repair: bool) -> object:
    """The distance matrix, continued in its folder."""
    found = distance_matrix(SURFACE, out=folder / "d.zarr", workers=1)
    assert np.array_equal(found[:], matrix())
    return found


def pipeline_seeds() -> list[Files]:
    steps = qg.DifferentialCoordinates(weights="cotangent") | qg.SurfaceScalar(clip=(5, 95))
    steps |= qg.QuasiGeodesicSpectrum(k=7) | qg.Paint(attribute="qgeo_scalar")
    hand = "# mine\nqgeo_pipeline: 1\nsteps:\n- SurfaceScalar\n- Paint: &p {attribute: qgeo_scalar}\n- Paint: *p\n"
    return [{"steps.yaml": steps.to_yaml().encode()}, {"steps.yaml": hand.encode()}]


def read_pipeline(folder: Path, repair: bool) -> object:
    """Steps of a saved pipeline."""
    return Pipeline.load(folder / "steps.yaml")


KEPT = {"matrix": V @ V.T, "names": ("a", "b"), "count": 3}


def read_stage(folder: Path, repair: bool) -> object:
    """A kept result: computed again where the file is damaged."""
    found = StageCache(directory=folder).get("stage-" + 32 * "0", lambda: dict(KEPT))
    assert found.keys() == KEPT.keys()
    assert np.array_equal(found["matrix"], KEPT["matrix"])
    return found


def stage_seeds() -> list[Files]:
    with TemporaryDirectory() as folder:
        read_stage(Path(folder), False)
        return [{path.name: path.read_bytes() for path in Path(folder).iterdir()}]


OTHERS = {
    "zarr": Target(functools.cache(zarr_seeds), zarr_changed, read_zarr),
    "pipeline": Target(functools.cache(pipeline_seeds), mutations.text_changed, read_pipeline),
    "stage_cache": Target(functools.cache(stage_seeds), mutations.bytes_changed, read_stage),
}

TARGETS: dict[str, Target] = {**MESHES, **MAPS, **LANDMARKS, **OTHERS}


# -- a reader that does what none should, to try the sandbox -------------------------------------------


def _hang() -> None:
    while True:
        pass


_MISDEEDS: dict[str, Callable[[], object]] = {
    "crash": os.abort,
    "hang": _hang,
    "devour": lambda: bytearray(4 << 30),
    "stumble": lambda: {}["x"],
    "shout": lambda: os.write(2, b"corrupted double-linked list"),
}


def misbehave(folder: Path, repair: bool) -> object:
    """Do what the first file's name says."""
    return _MISDEEDS[next(folder.iterdir()).name]()


MISDEED = Target(list, mutations.bytes_changed, misbehave)
