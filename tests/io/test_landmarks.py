"""Landmark files: what programs write is read as they mean it, what is written comes back, and nothing is guessed."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import qgeo_filters as qg
from qgeo_filters.io.landmarks import Landmarks

POINTS = np.array([[1.5, -2.0, 3.25], [0.0, 1e-3, -7.0]])
NAMES = ("nose", "left ear")


def read(folder: Path, name: str, text: str | bytes, **options: Any) -> Landmarks:
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return qg.read_landmarks(file, **options)


def assert_are(found: Landmarks, names: tuple[str, ...] = NAMES, points: np.ndarray = POINTS) -> None:
    assert found.names == names
    np.testing.assert_array_equal(found.points, points)


# -- the class ----------------------------------------------------------------------------------------


def test_landmarks_are_checked_copied_and_frozen() -> None:
    points = POINTS.copy()
    marks = Landmarks([" nose", "left\n ear"], points, [4, -1], "LPS")
    points[:] = 0
    assert_are(marks)
    assert marks.vertices.tolist() == [4, -1]
    assert marks.vertices.dtype == np.int64
    assert not marks.points.flags.writeable
    assert len(marks) == 2
    np.testing.assert_array_equal(marks["left ear"], POINTS[1])
    assert repr(marks) == "Landmarks(2 in LPS: nose, left ear)"
    with pytest.raises(AttributeError, match="never change"):
        marks.frame = "RAS"
    with pytest.raises(KeyError, match="no landmark 'tail'; there are nose, left ear"):
        marks["tail"]
    assert Landmarks(vertices=[3, 1]).names == ("1", "2")
    assert Landmarks(vertices=[3, -1]).is_known.tolist() == [True, False]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({}, "points or vertices"),
        ({"points": [[1, 2]]}, r"shape \(k, 3\), got \(1, 2\)"),
        ({"points": POINTS, "names": ["a"]}, "1 names for 2"),
        ({"points": POINTS, "vertices": [1]}, "2 whole numbers"),
        ({"vertices": [1.5]}, "1 whole numbers, got float64"),
        ({"points": [[1, 2, np.nan]]}, "landmark 0 is at"),
        ({"points": [[np.inf, 2, 1]]}, "neither finite"),
        ({"points": POINTS, "frame": "IJK"}, "'RAS', 'LPS' or None, got 'IJK'"),
    ],
)
def test_what_are_no_landmarks_is_refused(arguments: dict[str, Any], expected: str) -> None:
    with pytest.raises(qg.ParameterError, match=expected):
        Landmarks(**arguments)


def test_frames() -> None:
    marks = Landmarks(NAMES, POINTS, [1, 2], frame="RAS")
    turned = marks.in_frame("LPS")
    np.testing.assert_array_equal(turned.points, POINTS * [-1, -1, 1])
    assert (turned.frame, turned.names, turned.vertices.tolist()) == ("LPS", NAMES, [1, 2])
    assert marks.in_frame("RAS") is marks
    with pytest.raises(qg.ParameterError, match="do not say whether"):
        Landmarks(NAMES, POINTS).in_frame("LPS")


# -- what is written comes back -------------------------------------------------------------------------

NAMELESS = (".tps", ".landmarkAscii")
SUFFIXES = (".csv", ".tsv", ".txt", ".fcsv", ".mrk.json", ".tps", ".pts", ".landmarkAscii", ".pp")

_text = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=8)
_numbers = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)
_rows = st.lists(
    st.tuples(_text, st.one_of(st.none(), st.tuples(_numbers, _numbers, _numbers)), st.integers(-1, 2**40)),
    min_size=1,
    max_size=6,
)


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=_rows, frame=st.sampled_from([None, "RAS", "LPS"]))
@example(rows=[("", None, -1)], frame=None)  # nothing is known of it, but that it is there
def test_everything_that_the_format_holds_comes_back(tmp_path: Path, suffix: str, rows: list[Any], frame: Any) -> None:
    points = np.array([point or (np.nan,) * 3 for _, point, _ in rows])
    table = suffix in (".csv", ".tsv", ".txt")
    vertices = [vertex if table else -1 for _, _, vertex in rows]
    marks = Landmarks([name for name, _, _ in rows], points, vertices, frame)
    file = tmp_path / f"marks{suffix}"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        qg.write_landmarks(file, marks)
    again = qg.read_landmarks(file)
    np.testing.assert_array_equal(again.points, marks.points)
    np.testing.assert_array_equal(again.vertices, marks.vertices)
    if suffix in (".fcsv", ".mrk.json"):
        assert again.frame == (frame or "LPS")
    numbers = [str(i + 1) for i in range(len(marks))]
    if suffix in NAMELESS:
        assert again.names == tuple(numbers)
    elif suffix == ".pts":
        assert again.names == tuple(name.replace(" ", "_") or "_" for name in marks.names)
    elif table:
        assert again.names == marks.names
    else:  # a name that is empty is as good as none
        assert again.names == tuple(name or number for name, number in zip(marks.names, numbers, strict=True))


def test_what_a_format_drops_is_said(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="marks.tps: .tps holds no names, dropped: nose, left ear"):
        qg.write_landmarks(tmp_path / "marks.tps", Landmarks(NAMES, POINTS))
    with pytest.raises(qg.ParameterError, match=r"of landmark 1 \('b'\) only the vertex is known"):
        qg.write_landmarks(tmp_path / "marks.fcsv", Landmarks("ab", [POINTS[0], [np.nan] * 3], [1, 2]))
    assert not (tmp_path / "marks.fcsv").exists()
    qg.write_landmarks(tmp_path / "marks.csv", Landmarks("ab", vertices=[1, 2]))
    assert (tmp_path / "marks.csv").read_text() == "name,vertex\na,1\nb,2\n"
    with pytest.raises(qg.MeshError, match=r"unknown suffix '\.doc' of landmarks; written are \.csv"):
        qg.write_landmarks(tmp_path / "marks.doc", Landmarks("ab", vertices=[1, 2]))


# -- tables -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "name,x,y,z\nnose,1.5,-2,3.25\nleft ear,0,1e-3,-7\n",
        "nose,1.5,-2,3.25\nleft ear,0,1e-3,-7",
        '# made by hand\n\n"Label" , "Z","Y", "X" ,desc\n"nose", 3.25 ,-2.0,+1.5,"a, b"\r\n"left ear",-7,.001,0,\n',
        "Landmark;X (mm);Y (mm);Z (mm)\nnose;1,5;-2;3,25\nleft ear;0;1,0E-3;-7,0\n",
        "x\ty\tz\tname\n1.5\t-2\t3.25\tnose\n0\t0.001\t-7\tleft ear\n",
        "id,label,pos_x,pos_y,pos_z\n7,nose,1.5,-2,3.25\n8,left ear,0,.001,-7\n",
        ",name,x,y,z\n0,nose,1.5,-2,3.25\n1,left ear,0,0.001,-7\n",  # of pandas
    ],
)
def test_tables_that_people_make(tmp_path: Path, text: str) -> None:
    for encoding in ("utf-8", "utf-8-sig", "utf-16"):
        assert_are(read(tmp_path, "a.csv", text.encode(encoding)))
    assert_are(read(tmp_path, "a.csv", text.replace("\r", "").replace("\n", "\r\n")))


def test_tables_without_names(tmp_path: Path) -> None:
    for text in ("1.5 -2 3.25\n0 1e-3 -7\n", "  1.5,-2,3.25\n0,1e-3,-7", "x y z\n1.5 -2 3.25\n0 1e-3 -7"):
        assert_are(read(tmp_path, "a.txt", text), ("1", "2"))
    assert_are(read(tmp_path, "a.txt", "4 1.5 -2 3.25\n9 0 1e-3 -7\n"), ("4", "9"))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("17\n240\n", ("1", "2")),
        ("nose,17\near,240\n", ("nose", "ear")),
        ("name,vertex\nnose,17\near,240.0\n", ("nose", "ear")),
        ("Vertex ID;Label\n17;nose\n240;ear\n", ("nose", "ear")),
    ],
)
def test_tables_of_vertices(tmp_path: Path, text: str, names: tuple[str, ...]) -> None:
    found = read(tmp_path, "a.csv", text)
    assert (found.names, found.vertices.tolist()) == (names, [17, 240])
    assert np.isnan(found.points).all()


def test_tables_of_slicer_say_their_frame_and_what_is_not_defined(tmp_path: Path) -> None:
    header = "label,{},{},{},defined,selected,visible,locked,description\n"
    rows = "nose,1.5,-2.0,3.25,1,1,1,0,\nleft ear,0,0.001,-7,1,1,1,0,\nF_3,0,0,0,0,1,1,0,\n"
    for frame in ("RAS", "LPS"):
        found = read(tmp_path, "a.csv", header.format(*frame.lower()) + rows)
        assert_are(found, (*NAMES, "F_3"), np.vstack([POINTS, [np.nan] * 3]))
        assert found.frame == frame


def test_missing_landmarks_in_tables(tmp_path: Path) -> None:
    found = read(tmp_path, "a.csv", "name,x,y,z,vertex\na,NA,NA,NA,3\nb,,,,\nc,1,2,nan\n".replace(",nan\n", ",3,NA\n"))
    assert np.isnan(found.points[:2]).all()
    assert found.points[2].tolist() == [1, 2, 3]
    assert found.vertices.tolist() == [3, -1, -1]


# -- Slicer -------------------------------------------------------------------------------------------------

FCSV = """# Markups fiducial file version = 4.11
# CoordinateSystem = LPS
# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID
vtkMRMLMarkupsFiducialNode_0,1.5,-2.0,3.25,0,0,0,1,1,1,0,nose,,vtkMRMLScalarVolumeNode1
vtkMRMLMarkupsFiducialNode_1,0.0,0.001,-7,0,0,0,1,1,1,0,left ear,"by ""eye"", twice",
"""


@pytest.mark.parametrize(("said", "frame"), [("LPS", "LPS"), ("RAS", "RAS"), ("0", "RAS"), ("1", "LPS"), (None, "RAS")])
def test_fiducials_of_any_version_say_their_frame(tmp_path: Path, said: str | None, frame: str) -> None:
    line = f"# CoordinateSystem = {said}\n" if said else ""
    found = read(tmp_path, "a.fcsv", FCSV.replace("# CoordinateSystem = LPS\n", line))
    assert_are(found)
    assert found.frame == frame
    np.testing.assert_array_equal(found.in_frame("LPS").points[:, 0], POINTS[:, 0] * (1 if frame == "LPS" else -1))
    other = qg.read_landmarks(tmp_path / "a.fcsv", frame="RAS")
    np.testing.assert_array_equal(other.points, POINTS if frame == "RAS" else POINTS * [-1, -1, 1])


def test_fiducials_of_slicer_5_with_a_carriage_return_in_each_row(tmp_path: Path) -> None:
    rows = "1,1.5,-2,3.25,0,0,0,1,1,1,0,nose,,\r,2,0\n2,0,0.001,-7,0,0,0,1,1,1,0,left ear,,\r,2,0\n"
    rows += "3,0,0,0,0,0,0,1,1,1,0,F-3,,\r,0,0\n"
    head = FCSV[: FCSV.index("vtkMRML")]
    for text in (head + rows, (head + rows).replace("\r", "").replace("\n", "\r\n")):
        assert_are(read(tmp_path, "a.fcsv", text), (*NAMES, "F-3"), np.vstack([POINTS, [np.nan] * 3]))


@pytest.mark.parametrize(
    "text",
    [
        "# Fiducial List file a.fcsv\n# version = 2\n# columns = label,x,y,z,sel,vis\n"
        "nose,1.5,-2,3.25,1,1\nleft ear,0,0.001,-7,1,1\n",
        "#label,x,y,z,sel,vis\nnose,1.5,-2,3.25,1,1\nleft ear,0,0.001,-7,1,1\n",
        "# Columns = id,x,y,z,ow,ox,oy,oz,Vis,Sel,Lock,Name,Description\n"
        "id_1,1.5,-2,3.25,0,0,0,1,1,0,1,nose,a\nid_2,0,0.001,-7,0,0,0,1,1,0,1,left ear,b\n",
    ],
)
def test_fiducials_of_old_lists_and_of_scripts(tmp_path: Path, text: str) -> None:
    assert_are(read(tmp_path, "a.fcsv", text))


def markups(*points: dict[str, Any], **others: Any) -> str:
    return json.dumps({"markups": [{"type": "Fiducial", "controlPoints": list(points), **others}]})


def test_markups(tmp_path: Path) -> None:
    entries = [{"label": name, "position": point} for name, point in zip(NAMES, POINTS.tolist(), strict=True)]
    for name in ("a.mrk.json", "a.json"):
        found = read(tmp_path, name, markups(*entries, coordinateSystem="RAS"))
        assert_are(found)
        assert found.frame == "RAS"
    assert read(tmp_path, "a.mrk.json", markups(*entries)).frame == "LPS"
    empty = {"label": "c", "positionStatus": "undefined"}
    found = read(tmp_path, "a.mrk.json", markups(*entries, empty, {"position": [1, 2, 3]}))
    assert_are(found, (*NAMES, "c", "4"), np.vstack([POINTS, [np.nan] * 3, [1, 2, 3]]))


def test_markups_of_several_lists(tmp_path: Path) -> None:
    document = json.loads(markups({"position": [1, 2, 3]}, name="F"))
    document["markups"] += json.loads(markups({"position": [4, 5, 6]}, name="rim", type="Curve"))["markups"]
    with pytest.raises(qg.ParameterError, match=r"a.mrk.json: the file holds 2 sets .* by specimen=: F, rim"):
        read(tmp_path, "a.mrk.json", json.dumps(document))
    for which in ("rim", 1):
        assert qg.read_landmarks(tmp_path / "a.mrk.json", specimen=which).points.tolist() == [[4, 5, 6]]


# -- morphometrics, MeshLab ---------------------------------------------------------------------------------

TPS = """LM3=2
1.5 -2 3.25
0 0.001 -7
IMAGE=scans\\WT_07.ply
ID=0
SCALE=1

LM3=2
NA NA NA
2 4 6
CURVES=2
POINTS3D=1
1 1 1
POINTS=2
2 2 2
3 3 3
ID=mutant
SCALE=0.5
COMMENT=left = right
"""


def test_tps(tmp_path: Path) -> None:
    for which in (0, "0", "WT_07", "scans\\WT_07.ply"):
        assert_are(read(tmp_path, "a.tps", TPS, specimen=which), ("1", "2"))
    other = qg.read_landmarks(tmp_path / "a.tps", specimen="mutant")
    assert other.names == ("1", "2", "curve 1.1", "curve 2.1", "curve 2.2")
    assert np.isnan(other.points[0]).all()
    assert other.points[1:, 0].tolist() == [1, 0.5, 1, 1.5]
    with pytest.raises(qg.ParameterError, match="2 sets of landmarks, say which by specimen=: 0, mutant"):
        qg.read_landmarks(tmp_path / "a.tps")
    with pytest.raises(qg.ParameterError, match="no sets of landmarks are called 'x'; there are 0, mutant"):
        qg.read_landmarks(tmp_path / "a.tps", specimen="x")
    with pytest.raises(qg.ParameterError, match="between 0 and 1, got 2"):
        qg.read_landmarks(tmp_path / "a.tps", specimen=2)
    assert_are(read(tmp_path, "one.TPS", TPS[: TPS.index("\n\n")].replace("LM3", "lm")), ("1", "2"))


def test_pts(tmp_path: Path) -> None:
    text = "Version 1.0\n3\nS000 1.5 -2 3.25\nS001 0 1e-3 -7\nC000 9999 9999 9999\n"
    found = read(tmp_path, "a.pts", text)
    assert_are(found, ("S000", "S001", "C000"), np.vstack([POINTS, [np.nan] * 3]))
    for plain in ("2\n1.5 -2 3.25\n0 1e-3 -7\n", "1.5 -2 3.25\n0 1e-3 -7\n"):
        assert_are(read(tmp_path, "a.pts", plain), ("1", "2"))


def test_landmark_ascii(tmp_path: Path) -> None:
    head = "# AmiraMesh 3D ASCII 2.0\n\n\ndefine Markers 2\n\nParameters {\n    NumSets {},\n}\n\n"
    one = "Markers { float[3] Coordinates } @1\n"
    rows = "@1\n1.500000000000000e+00 -2 3.25\n0 1e-3 -7 \n"
    text = head.replace("{}", "1") + one + "\n# Data section follows\n" + rows
    assert_are(read(tmp_path, "a.landmarkAscii", text), ("1", "2"))
    two = one + "Markers { float[3] Coordinates2 } @2\n"
    text = head.replace("{}", "2") + two + "\n# Data section follows\n" + rows + "\n@2\n1 1 1\n2 2 2\n"
    assert_are(read(tmp_path, "a.landmarkascii", text, specimen=0), ("1", "2"))
    assert qg.read_landmarks(tmp_path / "a.landmarkascii", specimen="2").points[:, 0].tolist() == [1, 2]


def test_picked_points(tmp_path: Path) -> None:
    text = """<!DOCTYPE PickedPoints>
<PickedPoints>
 <DocumentData>
  <DateTime time="16:00:00" date="2014-12-31"/>
  <User name="me"/>
 </DocumentData>
 <point y="-2" z="3.25" active="1" name="nose" x="1.5"/>
 <point x="0" y="0.001" z="-7" name="left ear"/>
 <point x="0" y="0" z="0" active="0" name="tail"/>
</PickedPoints>
"""
    assert_are(read(tmp_path, "a.pp", text), (*NAMES, "tail"), np.vstack([POINTS, [np.nan] * 3]))


# -- what is wrong is said, and where ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.csv", "", "holds no landmarks"),
        ("a.csv", "# nothing\n\n", "holds no landmarks"),
        ("a.csv", "name,x,y,z\n", "holds no landmarks"),
        ("a.csv", "name,x,y,z\na,1,2,3\n\nb,1,two,3\n", "line 4: 'two' is no number"),
        ("a.csv", "name,x,y,z\na,1,2\n", "line 2 has 3 columns, expected at least 4"),
        ("a.csv", "name,x,y,z\na,1,NA,3\n", "line 2: 1 of 3 coordinates are missing"),
        ("a.csv", "a,1,2,1e999\n", "line 1: '1e999' is beyond all numbers"),
        ("a.csv", "a,1_0,2,3\n", "line 1: '1_0' is no number"),
        ("a.csv", "a,١,2,3\n", "line 1: '١' is no number"),
        ("a.csv", "1,2,3,4,5\n", "line 1 has 5 columns, but no header names them: expected are x y z"),
        ("a.csv", "name,vertex\na,1.5\n", "line 2: '1.5' is no whole number"),
        ("a.csv", "name,vertex\na,-7\n", "line 2: -7 is no vertex"),
        ("a.csv", "# head\n1,2,3\n# end\n", "line 3 has 1 columns, expected at least 3"),
        ("a.csv", "tip,1,2\n", "line 1: 'tip' is no number"),
        ("a.fcsv", "# CoordinateSystem = 2\n1,1,1,1\n", "system '2'; read are RAS and LPS"),
        ("a.fcsv", FCSV.replace("1.5", "x"), "line 4: 'x' is no number"),
        ("a.fcsv", FCSV + "7,1,2\n", "line 6 has 3 columns, expected id, x, y"),
        ("a.fcsv", FCSV[: FCSV.index("vtk")], "holds no landmarks"),
        ("a.mrk.json", "{", "no readable JSON"),
        ("a.mrk.json", "[" * 100000, "no readable JSON"),
        ("a.mrk.json", "[]", "no Markups of Slicer"),
        ("a.mrk.json", '{"markups": [{}]}', r"markups\[0\] has no list of controlPoints"),
        ("a.mrk.json", markups({"position": [1, 2]}), r"controlPoints\[0\]: a position needs 3 coordinates, got 2"),
        ("a.mrk.json", markups({"position": [1, 2, True]}), "'True' is no number"),
        ("a.mrk.json", markups({"position": [1, 2, 10**400]}), "is no number"),
        ("a.mrk.json", markups({"label": "a"}), r"controlPoints\[0\] has no position"),
        ("a.mrk.json", markups({"position": [1, 2, 3]}, coordinateSystem="HFS"), "system 'HFS'"),
        ("a.tps", "ID=3\n", "line 1: a specimen begins with LM3=, got 'ID=3'"),
        ("a.tps", "LM=1\n1 2\n", "line 2: the landmarks have two coordinates"),
        ("a.tps", "LM3=3\n1 2 3\nID=1\n", "line 1 announces 3 landmarks, where 1 follow"),
        ("a.tps", "LM3=99999999999\n1 2 3\n", "line 1 announces 99999999999 landmarks, where 1 follow"),
        ("a.tps", "LM3=1\n1 2 3\n4 5 6\n", "line 3: expected NAME=VALUE, got '4 5 6'"),
        ("a.tps", "LM3=1\n1 2 3\nSCALE=0\n", "line 3: SCALE must be a positive number"),
        ("a.tps", "LM3=1\n1e300 2 3\nSCALE=1e300\n", "beyond all numbers"),
        ("a.pts", "Version 1.0\n3\nS0 1 2 3\n", "line 2 announces 3 landmarks, where 1 follow"),
        ("a.pts", "version: 1\nn_points: 2\n{\n1 2\n}\n", "line 2"),
        ("a.landmarkAscii", "@1\n1 2 3\n", "no landmarks of Amira"),
        (
            "a.landmarkAscii",
            "# A\ndefine Markers 2\nMarkers { float[3] Coordinates } @1\n@1\n1 2 3\n",
            "has 1 landmarks",
        ),
        ("a.pp", "<PickedPoints>", "no readable XML"),
        ("a.pp", "<a/>", "no picked points of MeshLab, but 'a'"),
        ("a.pp", '<PickedPoints><point x="1" y="2"/></PickedPoints>', "point 0: 1 of 3 coordinates are missing"),
        ("a.xls", "1 2 3", "unknown suffix '.xls' of landmarks; read are .csv"),
    ],
)
def test_what_is_wrong_is_said_with_path_and_line(tmp_path: Path, name: str, text: str, expected: str) -> None:
    with pytest.raises(qg.MeshError, match=rf"{name}: .*{expected}"):
        read(tmp_path, name, text)


def test_what_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no such file: .*a\.csv"):
        qg.read_landmarks(tmp_path / "a.csv")
    (tmp_path / "b.csv").mkdir()
    with pytest.raises(IsADirectoryError, match="is a folder"):
        qg.read_landmarks(tmp_path / "b.csv")
    with pytest.raises(qg.ParameterError, match=r"c\.csv: these landmarks do not say whether they are RAS or LPS"):
        read(tmp_path, "c.csv", "1 2 3\n", frame="LPS")


def test_names_in_the_encoding_of_windows(tmp_path: Path) -> None:
    assert read(tmp_path, "a.csv", "Jochbogen müde,1,2,3\n".encode("cp1252")).names == ("Jochbogen müde",)
