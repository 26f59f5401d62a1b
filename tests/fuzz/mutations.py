"""Changes of files that make them lie: of bytes, of words and numbers, and of what lies inside a container.

All take a `random.Random`, so that a seed gives the same inputs everywhere.
"""

from __future__ import annotations

import io
import json
import random
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from typing import Any

Mutation = Callable[[random.Random, bytes], bytes]

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[^\s,:;{}\[\]()\"'<>=]+")
_ODD_NUMBERS = [
    b"0", b"-0", b"-1", b"1", b"2", b"3", b"255", b"65536", b"99999", b"2147483647", b"-2147483648", b"4294967295",
    b"9223372036854775807", b"-9223372036854775808", b"18446744073709551616", b"1" + 40 * b"0", 400 * b"9", b"1e9",
    b"3000000000", b"1e400", b"-1e308", b"1e-320", b"nan", b"-inf", b"0x10", b"1_0", b"1.5", b".", b"-", b"1e",
    "٣".encode(), "½".encode(), 5000 * b"7",
]  # fmt: skip
_ODD_BYTES = [b"\0", b"\r", b"\n", b"\xff\xfe", b"\xef\xbb\xbf", b"\\\n", b"#", b"\x1a", b"\xc2\x85", "\u2028".encode()]
_ODD_BYTES += [b'"', b"'", b"{", b"[", b"]", b"}", b"(", b"<", b"&", b"*", b"%", b",", b"/", b"-", b"\t", b"\x80"]
_ODD_WHOLE = [0, 1, 2, 3, 4, 5, 7, 9, 14, 15, 16, 127, 128, 255, 256, 65535, 2**20, 2**24, 2**28, 2**31 - 1, 2**31]
_ODD_WHOLE += [2**32 - 1, 2**32, 2**48, 2**63 - 1, 2**63, 2**64 - 1]


# -- bytes --------------------------------------------------------------------------------------------


def flip_bits(rng: random.Random, content: bytes) -> bytes:
    """A few bits turned over."""
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 8))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def set_whole_number(rng: random.Random, content: bytes) -> bytes:
    """A binary whole number replaced, such as a count, a size or an offset."""
    size, order = rng.choice((1, 2, 4, 4, 4, 8)), rng.choice(("<", "<", "<", ">"))
    if len(content) < size:
        return content
    # Headers stand at the beginning.
    end = len(content) - size if rng.random() < 0.5 else min(len(content) - size, 256)
    start = rng.randint(0, end)
    start -= start % size if rng.random() < 0.7 else 0
    value = rng.choice(_ODD_WHOLE) % 2 ** (8 * size)
    if rng.random() < 0.3:
        old = int.from_bytes(content[start : start + size], "little" if order == "<" else "big")
        value = (old + rng.choice((-8, -4, -1, 1, 4, 8))) % 2 ** (8 * size)
    code = {1: "B", 2: "H", 4: "I", 8: "Q"}[size]
    return content[:start] + struct.pack(order + code, value) + content[start + size :]


def truncate(rng: random.Random, content: bytes) -> bytes:
    """The beginning only."""
    return content[: rng.randint(0, len(content))]


def drop_chunk(rng: random.Random, content: bytes) -> bytes:
    """Some bytes missing."""
    start, end = _span(rng, content)
    return content[:start] + content[end:]


def repeat_chunk(rng: random.Random, content: bytes) -> bytes:
    """Some bytes twice or often."""
    start, end = _span(rng, content)
    return content[:end] + content[start:end] * rng.choice((1, 1, 2, 20)) + content[end:]


def swap_chunks(rng: random.Random, content: bytes) -> bytes:
    """Two parts exchanged."""
    a, b, c, d = sorted(rng.randint(0, len(content)) for _ in range(4))
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def insert_bytes(rng: random.Random, content: bytes) -> bytes:
    """Odd characters, or noise, put in somewhere."""
    place = rng.randint(0, len(content))
    noise = rng.choice(_ODD_BYTES) * rng.choice((1, 1, 1, 300)) if rng.random() < 0.8 else rng.randbytes(12)
    return content[:place] + noise + content[place:]


# -- words and lines ----------------------------------------------------------------------------------


def odd_number(rng: random.Random, content: bytes) -> bytes:
    """A number in text replaced by a huge, negative or senseless one; in half of the cases one of the first."""
    found = list(_NUMBER.finditer(content, 0, 100_000))
    if not found:
        return flip_bits(rng, content)
    one = rng.choice(found[:6] if rng.random() < 0.5 else found)
    return content[: one.start()] + rng.choice(_ODD_NUMBERS) + content[one.end() :]


def swap_words(rng: random.Random, content: bytes) -> bytes:
    """Two words exchanged, or one put in the place of another."""
    found = list(_WORD.finditer(content, 0, 100_000))
    if len(found) < 2:
        return flip_bits(rng, content)
    one, other = sorted(rng.sample(found, 2), key=lambda word: word.start())
    left, right = (other.group(), one.group()) if rng.random() < 0.5 else (one.group(), one.group())
    return content[: one.start()] + left + content[one.end() : other.start()] + right + content[other.end() :]


def change_lines(rng: random.Random, content: bytes) -> bytes:
    """A line lost, repeated or moved, or all lines ended in another way."""
    lines = content.split(b"\n")
    kind, place = rng.randrange(5), rng.randrange(len(lines))
    if kind == 0:
        del lines[place]
    elif kind == 1:
        lines.insert(place, lines[place])
    elif kind == 2:
        lines.insert(rng.randrange(len(lines)), lines.pop(place))
    else:
        return content.replace(b"\n", rng.choice((b"\r\n", b"\r", b" ", b"")))
    return b"\n".join(lines)


BYTES: tuple[Mutation, ...] = (
    flip_bits, set_whole_number, set_whole_number, truncate, drop_chunk, repeat_chunk, swap_chunks, insert_bytes,
)  # fmt: skip
TEXT: tuple[Mutation, ...] = (
    odd_number, odd_number, odd_number, swap_words, change_lines, truncate, drop_chunk, repeat_chunk, insert_bytes,
    flip_bits,
)  # fmt: skip


def several(*mutations: Mutation) -> Mutation:
    """One to four of these, one after the other."""

    def mutate(rng: random.Random, content: bytes) -> bytes:
        for _ in range(rng.choice((1, 1, 2, 4))):
            content = rng.choice(mutations)(rng, content)
        return content

    return mutate


bytes_changed = several(*BYTES)
text_changed = several(*TEXT)
both_changed = several(*BYTES, *TEXT)


# -- inside of containers -----------------------------------------------------------------------------


def json_changed(rng: random.Random, content: bytes) -> bytes:
    """A JSON document with some of its values replaced, removed or moved: it still parses."""
    document = json.loads(content)
    for _ in range(rng.choice((1, 1, 2, 3))):
        holders = list(_holders(document))
        if not holders:
            return rng.choice(_ODD_JSON).encode()
        holder, key = rng.choice(holders)
        kind = rng.randrange(5)
        if kind == 0:
            del holder[key]
        elif kind == 1:
            other, name = rng.choice(holders)
            holder[key] = json.loads(json.dumps(other[name]))
        elif kind == 2 and isinstance(holder[key], int | float):
            holder[key] = rng.choice((-1, 0, 1, 10**3, 2**31, 2**40, 10**30, 1.5, -holder[key], holder[key] + 1, 1e308))
        else:
            holder[key] = json.loads(rng.choice(_ODD_JSON))
    return json.dumps(document).encode()


_ODD_JSON = [
    "null", "true", "-1", "0", "2147483648", "18446744073709551616", "1e300", "0.5", '""', '"x"', '"../x"', '"data:,"',
    '"data:;base64,%"', "[]", "{}", "[[]]", "[-1]", "[null]", "[1, 2, 3]", '{"x": []}', '"a\\u0000b"', '"\\ud800"',
    "NaN", "[" * 60 + "]" * 60, f"[{'0, ' * 200}0]",
]  # fmt: skip


def _holders(document: Any) -> Any:
    """Each place of a document as (mapping or list, key)."""
    items = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in list(items):
        yield document, key
        if isinstance(value, dict | list):
            yield from _holders(value)


def in_json(rng: random.Random, content: bytes) -> bytes:
    """JSON with another structure or other text."""
    return json_changed(rng, content) if rng.random() < 0.7 else both_changed(rng, content)


def in_zip(mutate: Mutation) -> Mutation:
    """A zip archive in which a member is changed and its checksum right again; now and then the archive's own bytes."""

    def changed(rng: random.Random, content: bytes) -> bytes:
        if rng.random() < 0.35:
            return bytes_changed(rng, content)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = {info.filename: archive.read(info) for info in archive.infolist()}
        name = rng.choice(list(members))
        kind = rng.randrange(8)
        if kind == 0:
            del members[name]
        elif kind == 1:
            members[rng.choice(("x.npy", "x", "../x.npy", name + "x", name.upper()))] = members.pop(name)
        elif kind == 2:
            members[name] = members[rng.choice(list(members))]
        else:
            members[name] = mutate(rng, members[name])
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
            for member, value in members.items():
                archive.writestr(member, value)
        return out.getvalue()

    return changed


def in_npy(rng: random.Random, content: bytes) -> bytes:
    """A NumPy file with another header, most of the time one that is whole."""
    if rng.random() < 0.4 or content[:6] != b"\x93NUMPY":
        return bytes_changed(rng, content)
    length = int.from_bytes(content[8:10], "little")
    header = content[10 : 10 + length]
    if rng.random() < 0.5:
        kind = rng.choice((b"|O", b"<U9", b"|S0", b"<c16", b"<M8[s]", b"|b1", b">i8", b"<f2", b"|V8", b"<i3", b"|u1"))
        header = re.sub(rb"'descr': '[^']*'", b"'descr': '" + kind + b"'", header)
    if rng.random() < 0.5:
        shape = rng.choice((b"()", b"(-1,)", b"(0,)", b"(4000000000,)", b"(1, 1)", b"(2,)", b"(0, 9999999999)", b"'x'"))
        header = re.sub(rb"'shape': \([^)]*\)", b"'shape': " + shape, header)
    if rng.random() < 0.4:
        header = text_changed(rng, header)
    header = header[:65000]
    return content[:8] + struct.pack("<H", len(header)) + header + content[10 + length :]


def in_deflated_matrices(rng: random.Random, content: bytes) -> bytes:
    """A MATLAB file with its bytes changed inside of what is compressed, sizes made right again."""
    if content[124:128] not in (b"\x00\x01IM", b"\x01\x00MI") or rng.random() < 0.3:
        return bytes_changed(rng, content)
    parts, place = [content[:128]], 128
    elements = []
    while place + 8 <= len(content):
        kind, size = struct.unpack("<II", content[place : place + 8])
        elements.append((kind, content[place + 8 : place + 8 + size]))
        place += 8 + size
    chosen = rng.randrange(len(elements)) if elements else -1
    for number, (kind, data) in enumerate(elements):
        if number == chosen:
            plain = zlib.decompress(data) if kind == 15 else struct.pack("<II", kind, len(data)) + data
            plain = bytes_changed(rng, plain)
            kind, data = (15, zlib.compress(plain)) if rng.random() < 0.5 else (14, plain[8:])
        parts.append(struct.pack("<II", kind, len(data)) + data)
    return b"".join(parts)


def in_glb(rng: random.Random, content: bytes) -> bytes:
    """A binary glTF with another JSON chunk of the right length, or other bytes."""
    if rng.random() < 0.4:
        return bytes_changed(rng, content)
    length = int.from_bytes(content[12:16], "little")
    document = in_json(rng, content[20 : 20 + length])
    document += b" " * (-len(document) % 4)
    rest = content[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(document) + len(rest), len(document), 0x4E4F534A)
    return head + document + rest


def in_ply(rng: random.Random, content: bytes) -> bytes:
    """A PLY file with another header or other data."""
    if rng.random() < 0.3:
        return both_changed(rng, content)
    header, mark, data = content.partition(b"end_header\n")
    if rng.random() < 0.7:
        return text_changed(rng, header) + mark + data
    return header + mark + both_changed(rng, data)


def _span(rng: random.Random, content: bytes) -> tuple[int, int]:
    start = rng.randint(0, len(content))
    return start, min(len(content), start + rng.choice((1, 4, 8, 16, 64, 500)))
