"""Parts of the repository's Markdown files within the pages, so that nothing is written twice.

A line ``<!-- text of README.md: How fast, how exact -->`` in a page becomes that section of the file, its heading
included; without a heading, the whole file. Links between the files become links between the pages, all others
lead to the repository.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: The page, of this folder, that shows a file.
PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "benchmarks/README.md": "benchmarks.md",
    "benchmarks/tosca_lowres.md": "tosca_lowres.md",
}

_REQUEST = re.compile(r"^<!-- text of (?P<file>[^:\n]+?)(?:: (?P<heading>.+?))? -->$", re.MULTILINE)
_LINK = re.compile(r"(?P<image>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
_FENCE = re.compile(r"^(```.*?^```)$", re.MULTILINE | re.DOTALL)
_HEADING = re.compile(r"^(#+) (.+)$", re.MULTILINE)


def with_repository_text(page: str, repository: str) -> str:
    """The page with every request replaced by what it asks for.

    Parameters
    ----------
    page : str
    repository : str
        Address at which files are seen that no page shows.

    Raises
    ------
    ValueError
        A file without such a heading.
    """

    def asked_for(request: re.Match[str]) -> str:
        text = (ROOT / request["file"]).read_text(encoding="utf-8")
        part = section(text, request["heading"], request["file"]) if request["heading"] else text
        return with_links(part, request["file"], repository)

    return _REQUEST.sub(asked_for, page)


def requested(page: str) -> list[str]:
    """Files of the repository that a page takes parts of."""
    return [request["file"] for request in _REQUEST.finditer(page)]


def section(text: str, heading: str, name: str) -> str:
    """From a heading to the next one that is no deeper."""
    headings = [found for found in _HEADING.finditer(text) if not _within_fence(text, found.start())]
    for number, found in enumerate(headings):
        if found[2] == heading:
            later = (other.start() for other in headings[number + 1 :] if len(other[1]) <= len(found[1]))
            return text[found.start() : next(later, len(text))].rstrip() + "\n"
    raise ValueError(f"{name} has no heading {heading!r}; it has {', '.join(repr(found[2]) for found in headings)}")


def with_links(text: str, name: str, repository: str) -> str:
    """The text with its links as they must be on a page of this folder; what stands in fences is left alone."""

    def link(found: re.Match[str]) -> str:
        target, _, anchor = found["target"].partition("#")
        if not target or re.match(r"[a-z]+:", target):
            return found[0]
        file = posixpath.normpath(posixpath.join(posixpath.dirname(name), target))
        if found["image"]:
            target = posixpath.relpath(file, "docs")
        elif file in PAGES:
            target = PAGES[file] + (f"#{anchor}" if anchor else "")
        else:
            target = f"{repository}/{'tree' if (ROOT / file).is_dir() else 'blob'}/main/{file}"
        return f"{found['image']}[{found['text']}]({target})"

    parts = _FENCE.split(text)  # texts and fences in turn
    return "".join(part if number % 2 else _LINK.sub(link, part) for number, part in enumerate(parts))


def _within_fence(text: str, position: int) -> bool:
    return len(re.findall(r"^```", text[:position], re.MULTILINE)) % 2 == 1
