"""OFF, OBJ and ascii STL as people have them: white space, marks, encodings, lines that end anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import icosphere

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.io.formats import read_raw
from qgeo_filters.io.text_numbers import numbers_of
from qgeo_filters.surface import Surface

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])
POINTS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
TRIANGLES = "3 0 1 2\n3 0 2 3\n"
OFF = f"OFF\n4 2 0\n{POINTS}{TRIANGLES}"
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
FACET = "facet normal 0 0 1\n outer loop\n  vertex {}\n  vertex {}\n  vertex {}\n endloop\nendfacet\n"
FACETS = FACET.format("0 0 0", "1 0 0", "1 1 0"), FACET.format("0 0 0", "1 1 0", "0 1 0")
STL = f"solid a\n{''.join(FACETS)}endsolid a\n"
TEXTS = {"off": OFF, "obj": OBJ, "stl": STL}


def read(tmp_path, suffix, text, **options):
    file = tmp_path / f"a.{suffix}"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_raw(file, **options)


def assert_is_square(raw):
    np.testing.assert_array_equal(raw.vertices, SQUARE)
    np.testing.assert_array_equal(raw.faces, HALVES)


# -- all three ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be"])
@pytest.mark.parametrize("suffix", TEXTS)
def test_marks_and_line_ends(tmp_path, suffix, encoding, ends):
    text = TEXTS[suffix].replace("\n", ends)
    if encoding == "utf-16-be":
        text = "\ufeff" + text
    assert_is_square(read(tmp_path, suffix, text.encode(encoding)))


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize("suffix", TEXTS)
def test_names_in_any_encoding(tmp_path, suffix, encoding):
    text = {
        "off": OFF.replace("4 2 0", "4 2 0 # Größe"),
        "obj": f"o Größe\n{OBJ}",
        "stl": STL.replace("d a", "d Größe"),
    }
    assert_is_square(read(tmp_path, suffix, text[suffix].encode(encoding)))


@pytest.mark.parametrize("suffix", TEXTS)
def test_numbers_are_read_to_the_last_bit(tmp_path, suffix):
    v, f = icosphere(2)
    v = v * np.pi
    file = tmp_path / f"a.{suffix}"
    if suffix == "stl":
        corners = [FACET.format(*(" ".join(map(repr, p)) for p in v[t].tolist())) for t in f]
        file.write_text(f"solid\n{''.join(corners)}endsolid\n")
    else:
        Surface(v, f).write(file)
    raw = read_raw(file)
    np.testing.assert_array_equal(np.asarray(raw.vertices)[np.asarray(raw.faces)], v[f])


def test_long_texts_are_taken_in_pieces_that_do_not_show():
    text = b"1.25 -3e-2\n" * 500_000  # 5.5 MB
    found = numbers_of(text + b"7 1_0 8\n")
    np.testing.assert_array_equal(found.values, [*np.tile([1.25, -0.03], 500_000), 7])
    np.testing.assert_array_equal(found.counts, [*np.full(500_000, 2), 1])
    np.testing.assert_array_equal(found.lines, np.arange(1, 500_002))
    assert found.stopped_by == "line 500001: '1_0' is no number"


@pytest.mark.filterwarnings("error")  # of NumPy
@pytest.mark.parametrize("word", ["1_0", "0x1", "1,5", "--1", "\0", "1e", "٣", "½"])
@pytest.mark.parametrize("suffix", TEXTS)
def test_words_that_are_no_numbers(tmp_path, suffix, word):
    with pytest.raises(MeshError, match=r"line \d+: '.*' is no number"):
        read(tmp_path, suffix, TEXTS[suffix].replace("1 1 0", f"1 {word} 0", 1))


@pytest.mark.parametrize("suffix", ["off", "obj"])
def test_repair_removes_faces_of_too_few_corners_and_says_so(tmp_path, suffix):
    text = {"off": OFF.replace("4 2 0", "4 4 0") + "2 0 1\n0\n", "obj": OBJ + "f 2 3\nf\n"}[suffix]
    with pytest.raises(MeshError, match=r"face 2 has 2 corners .*repair=True removes them"):
        read(tmp_path, suffix, text)
    done = repair_surface(tmp_path / f"a.{suffix}")
    assert done.report == ("2 faces with fewer than three corners removed (face 2, 3)",)
    assert done.surface.area == 1


# -- OFF ----------------------------------------------------------------------------------------------

FREE = {
    "faces over several lines": OFF.replace("3 0 1 2", "3 0\n1\n\n2"),
    "vertices over several lines": OFF.replace("1 1 0", "1\n1 0"),
    "two vertices on a line": OFF.replace("\n1 1 0", " 1 1 0"),
    "two faces on a line": OFF.replace("\n3 0 2", " 3 0 2"),
    "all on one line": OFF.replace("\n", " "),
    "a word on each line": OFF.replace(" ", "\n"),
    "tabs and form feeds": OFF.replace(" ", "\t").replace("1\t1", "1\f1"),
    "glued header": OFF.replace("OFF\n", "OFF"),
    "no header": OFF.replace("OFF\n", ""),
    "lower case": OFF.lower(),
    "counts spread": OFF.replace("4 2 0", "4\n2\n0"),
    "no count of edges": OFF.replace("4 2 0", "4 2"),
    "comments between all": "# OFF\n" + OFF.replace("\n", " # 7 8 9\n# OFF\n"),
    "colours of faces": OFF.replace("0 1 2\n", "0 1 2 255 0 0\n").replace("0 2 3\n", "0 2 3 3\n"),
    "colours behind faces on two lines": OFF.replace("0 1 2\n", "0 1\n2 255 0 0\n").replace("0 2 3\n", "0 2 3 3\n"),
    "edges behind the faces": OFF + "2 0 1\n2 1 2\n",
    "words behind the faces": OFF + "made by hand\n",
    "texture coordinates": OFF.replace("OFF", "STOFF").replace("0\n", "0 .5 .5\n").replace("4 2 0 .5 .5", "4 2 0"),
}


@pytest.mark.parametrize("name", FREE)
def test_off_is_a_stream(tmp_path, name):
    assert_is_square(read(tmp_path, "off", FREE[name]))


@pytest.mark.parametrize("joined", ["\n", " "])
@pytest.mark.parametrize("kind", ["C", "N", "CN", "STCN"])
def test_off_with_colours_and_normals(tmp_path, kind, joined):
    colors, normals = np.arange(16).reshape(4, 4) * 9, np.tile([0, 0, 1.0], (4, 1))
    parts = [SQUARE]
    parts += [normals] if "N" in kind else []
    parts += [colors] if "C" in kind else []
    parts += [np.full((4, 2), 0.25)] if "ST" in kind else []
    rows = [" ".join(f"{value:g}" for value in row) for row in np.column_stack(parts)]
    raw = read(tmp_path, "off", f"{kind}OFF\n4 2 0\n{joined.join(rows)}\n{TRIANGLES}")
    assert_is_square(raw)
    assert set(raw.attributes) == ({"colors"} if "C" in kind else set()) | ({"normals"} if "N" in kind else set())
    if "C" in kind:
        np.testing.assert_array_equal(raw.attributes["colors"], colors)
        assert raw.attributes["colors"].dtype == np.uint8
    if "N" in kind:
        np.testing.assert_array_equal(raw.attributes["normals"], normals)


def test_off_with_colours_in_floats_and_without_alpha(tmp_path):
    rows = POINTS.replace("\n", " 1 .5 0\n")
    for body in (rows, rows.replace("\n", " ")):
        raw = read(tmp_path, "off", f"COFF\n4 2 0\n{body}{TRIANGLES}")
        assert_is_square(raw)
        np.testing.assert_array_equal(raw.attributes["colors"], [[1, 0.5, 0]] * 4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("OFF\n2000000000 2000000000 0\n0 0 0\n", "2000000000 vertices and .* the 3 numbers that follow do not make"),
        ("OFF\n-3 1 0\n0 0 0\n", "the counts of vertices and faces are missing, found '-3 1 0'"),
        ("OFF\n1.5 1 0\n0 0 0\n", "the counts of vertices and faces are missing"),
        ("OFF\n4\n", "the counts of vertices and faces are missing, found '4'"),
        ("OFF\nnan 1 0\n0 0 0\n", "the counts of vertices and faces are missing"),
        (OFF.replace("3 0 1 2", "-3 0 1 2"), "line 7 is no face: '-3 0 1 2'"),
        (OFF.replace("3 0 1 2", "1e300 0 1 2"), "line 7 is no face"),
        (OFF.replace("3 0 1 2", "9 0 1 2"), "line 7 is no face"),
        (OFF.replace("3 0 1 2", "3 0 1 nan"), "line 7 is no face"),
        ("OFF BINARY\n\0\0\0\1", "OFF files of kind OFF BINARY are not read"),
        ("4nOFF\n4 2 0\n", "OFF files of kind 4nOFF are not read"),
        ("nOFF\n4 2 0\n", "OFF files of kind nOFF are not read"),
        ("4OFF\n4 2 0\n", "OFF files of kind 4OFF are not read"),
        ("OFFSET 4 2 0\n", "not an OFF file: it begins with 'OFFSET'"),
    ],
)
def test_off_that_does_not_hold_what_it_announces(tmp_path, text, message):
    with pytest.raises(MeshError, match=message):
        read(tmp_path, "off", text)


# -- OBJ ----------------------------------------------------------------------------------------------

OBJ_DIALECTS = {
    "comment that ends in a backslash": "# made in C:\\models\\\n" + OBJ,
    "comment behind a line, with a backslash": OBJ.replace("v 1 0 0", "v 1 0 0 # C:\\"),
    "line separators in a name": "o part\u2028v 5 5 5\u0085v 6 6 6\x0bv 7 7 7\x0cv 8 8 8\x1cv 9 9 9\n" + OBJ,
    "lines that begin with blanks": OBJ.replace("\n", "\n \t"),
    "lines continued twice": OBJ.replace("f 1 2 3", "f \\\n1 2 \\ \n3"),
    "a backslash at the end of the file": OBJ + "o a\\",
    "homogeneous coordinates": OBJ.replace("0\nf", "0 1\nf").replace("v 0 0 0", "v 0 0 0 1"),
    "counted from the last vertex so far": "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n",
    "texture and normal": OBJ.replace("f 1 2 3", "f 1/7 2//9 3/8/9").replace("f 1 3 4", "f -4/-1/-2 3/1 4/"),
    "other keywords": OBJ + "vp 1 2\nvn 0 0 1\nvt 0 0\nfo 1 2 3\nl 1 2\np 1\nvertex 1 2 3\nface 1 2 3\n",
}


@pytest.mark.parametrize("name", OBJ_DIALECTS)
def test_obj_dialects(tmp_path, name):
    assert_is_square(read(tmp_path, "obj", OBJ_DIALECTS[name]))


def test_obj_keeps_vertices_that_no_face_names_and_the_order(tmp_path):
    raw = read(tmp_path, "obj", "v 9 9 9\n" + OBJ.replace("f 1 2 3\nf 1 3 4", "usemtl b\nf 3 4 5\nusemtl a\nf 2 3 4"))
    np.testing.assert_array_equal(raw.vertices, [[9, 9, 9], *SQUARE])
    np.testing.assert_array_equal(raw.faces, [[2, 3, 4], [1, 2, 3]])


@pytest.mark.parametrize("alpha", ["", " 1"])
def test_obj_with_colours(tmp_path, alpha):
    text = (
        "".join(f"v {row} {k / 8:g} .5 .25{alpha}\n" for k, row in enumerate(POINTS.splitlines()))
        + "f 1 2 3\nf 1 3 4\n"
    )
    raw = read(tmp_path, "obj", text)
    assert_is_square(raw)
    expected = np.column_stack([np.arange(4) / 8, np.full(4, 0.5), np.full(4, 0.25), *([np.ones(4)] if alpha else [])])
    np.testing.assert_array_equal(raw.attributes["colors"], expected)


def test_obj_with_colours_here_and_there(tmp_path):
    with pytest.warns(UserWarning, match=r"a\.obj: colours passed over, which only 1 vertex of 4 have"):
        raw = read(tmp_path, "obj", OBJ.replace("v 1 0 0", "v 1 0 0 .5 .5 .5"))
    assert_is_square(raw)
    assert raw.attributes == {}


def test_obj_that_counts_from_zero_is_repaired_as_other_missing_vertices_are(tmp_path):
    text = OBJ + "f 0 1 2\nf 1 2 99\n"
    with pytest.raises(MeshError, match="line 7 refers to vertex 0, but OBJ counts from 1: 'f 0 1 2'"):
        read(tmp_path, "obj", text)
    assert "2 faces with missing vertices removed" in repair_surface(tmp_path / "a.obj").report


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (OBJ.replace("v 1 0 0", "v 1 0"), "line 2 is no vertex: 'v 1 0'"),
        (OBJ.replace("v 1 0 0", "v"), "line 2 is no vertex: 'v'"),
        (OBJ.replace("v 1 0 0", "v 1 \\\n0"), "line 3 is no vertex: 'v 1  0'"),
        (OBJ.replace("f 1 2 3", "f 1 2 3.5"), "line 5 is no face: 'f 1 2 3.5'"),
        (OBJ.replace("f 1 2 3", "f 1 2 inf"), "line 5 is no face"),
        (OBJ.replace("f 1 2 3", "f 1 2 /3"), "line 5: '/3' is no number"),
        (OBJ.replace("f 1 2 3", "f 1 2 /3/4"), "line 5: '/3.*' is no number"),
    ],
)
def test_broken_obj_lines_are_named(tmp_path, text, message):
    with pytest.raises(MeshError, match=message):
        read(tmp_path, "obj", text)


# -- STL ----------------------------------------------------------------------------------------------

STL_DIALECTS = {
    "several solids": f"solid a\n{FACETS[0]}endsolid a\nsolid b\n{FACETS[1]}endsolid b\n",
    "capitals": STL.upper(),
    "all on one line": STL.replace("\n", " "),
    "no end": STL.replace("endsolid a\n", ""),
    "a name like a keyword": STL.replace("solid a", "solid vertex 1 2 3 endsolid outer loop"),
    "blank lines before": "\n \n" + STL,
    "no indents": STL.replace("  ", "").replace("\n ", "\n"),
}


@pytest.mark.parametrize("name", STL_DIALECTS)
def test_stl_dialects(tmp_path, name):
    assert_is_square(read(tmp_path, "stl", STL_DIALECTS[name]))


def test_a_facet_that_lost_a_corner_does_not_shift_the_others(tmp_path):
    text = STL.replace("  vertex 1 0 0\n", "").replace("  vertex 0 1 0\n", "  vertex 0 1 0\n  vertex 0 .5 0\n")
    with pytest.raises(MeshError, match=r"face 0 has 2 corners"):
        read(tmp_path, "stl", text)
    raw = read(tmp_path, "stl", text, repair=True)
    assert raw.notes[0] == "1 face with fewer than three corners removed (face 0)"
    assert Surface(raw.vertices, raw.faces).area == 0.5


def test_corners_between_facets_are_refused(tmp_path):
    with pytest.raises(MeshError, match="corners found in the STL file, which make no triangles"):
        read(tmp_path, "stl", "solid a\nvertex 1 2 3\n" + "".join(FACETS))
    with pytest.raises(MeshError, match="line 5 is no corner of a facet: 'vertex 1 0'"):
        read(tmp_path, "stl", STL.replace("vertex 1 0 0", "vertex 1 0"))


@pytest.mark.parametrize("part", [" ", "\n", "\t \n", "vertex ", "vertex\n", "\\\n", "#", "/"])
@pytest.mark.parametrize("suffix", TEXTS)
def test_half_a_megabyte_of_one_thing_is_refused(tmp_path, suffix, part):
    # A search that goes back over what it passed takes hours here.
    begin = {"off": "OFF\n4 2 0\n", "obj": "v 0 0 0\nf 1", "stl": "solid a\nouter loop\nvertex 1"}[suffix]
    file = tmp_path / f"a.{suffix}"
    file.write_text(begin + part * (500_000 // len(part)))
    with pytest.raises(MeshError):
        Surface.read(file)
