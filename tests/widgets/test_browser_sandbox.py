"""The browser module where front ends of anywidget run it: from a blob or data URL, with no eval and no network.

VS Code's renderer of notebooks imports a widget's module from a blob URL, within a sandbox; Colab shows outputs in a
frame whose origin is its own. Here a page stands for either, whose policy forbids whatever is not the module itself.
"""

from __future__ import annotations

import base64
import json

import browser as tools
import numpy as np
import pytest

import qgeo_widgets as qw
from qgeo_widgets.compared_colors import CARRIED, TEXTURE
from qgeo_widgets.rendering import browser_module
from qgeo_widgets.rendering.encoding import converted

pytestmark = pytest.mark.browser

_POLICY = (
    "default-src 'none'; script-src 'nonce-start' {kind}:; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'none'{more}"
)
_PAGE = """<!DOCTYPE html><meta charset="utf-8"><style>{style}</style><div id="widget"></div>
<script nonce="start" type="module">
const state = JSON.parse({state});
const bytes = (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const revived = (item) => {{
  if (Array.isArray(item)) return item.map(revived);
  if (item === null || typeof item !== 'object') return item;
  if ('base64' in item) return bytes(item.base64);
  return Object.fromEntries(Object.entries(item).map(([key, each]) => [key, revived(each)]));
}};
const values = revived(state.first);
const heard = {{}};
window.sent = [];
const model = {{
  get: (name) => values[name],
  set: (name, value) => {{ values[name] = value; }},
  save_changes: () => {{}},
  on: (event, act) => {{ (heard[event] ??= []).push(act); }},
  off: (event, act) => {{ heard[event] = (heard[event] ?? []).filter((each) => each !== act); }},
  send: (content) => window.sent.push(content),
}};
window.change = () => {{
  Object.assign(values, revived(state.second));
  for (const name of Object.keys(state.second)) for (const act of heard[`change:${{name}}`] ?? []) act();
}};
const text = {module};
const url = '{kind}' === 'blob' ? URL.createObjectURL(new Blob([text], {{type: 'text/javascript'}}))
  : `data:text/javascript;base64,${{btoa(unescape(encodeURIComponent(text)))}}`;
const {{default: widget}} = await import(url);
window.end = widget.render({{model, el: document.getElementById('widget')}});
</script>"""


def _state(values: dict[str, object]) -> object:
    """What a front end has of traits: views of bytes, as `base64` here."""

    def encoded(data: object) -> object:
        if isinstance(data, bytes):
            return {"base64": base64.b64encode(data).decode()}
        if isinstance(data, dict):
            return {key: encoded(each) for key, each in data.items()}
        return [encoded(each) for each in data] if isinstance(data, (list, tuple)) else data

    return encoded(converted(values, np.ndarray.tobytes))


def _document(pair, kind: str) -> str:
    texture = np.array([[[230, 40, 40], [40, 60, 230]]], np.uint8).repeat(8, axis=0).repeat(4, axis=1)
    widget = qw.compare(pair[0], pair[1], p2p=pair[2], texture=texture)
    widget.mode = CARRIED
    scene = widget._viewer._scene
    names = [name for name in scene.keys if not name.startswith("_")]
    first = {name: getattr(scene, name) for name in names if name not in ("layout", "tabbable", "tooltip", "comm")}
    widget.mode = TEXTURE
    state = {"first": _state(first), "second": _state({"paints": scene.paints})}
    widget.close()
    return _PAGE.format(
        style=browser_module.style(),
        state=json.dumps(json.dumps(state)),
        module=json.dumps(browser_module.as_anywidget()).replace("</", "<\\/"),
        kind=kind,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "more"),
    [("blob", ""), ("data", ""), ("blob", "; sandbox allow-scripts")],
    ids=["blob", "data", "no origin"],
)
def test_the_module_runs_within_a_policy_that_forbids_all_else(page, pair, kind, more):
    asked, said = [], []

    def answer(route):
        asked.append(route.request.url)
        if len(asked) > 1:
            route.abort()
            return
        policy = _POLICY.format(kind=kind, more=more)
        headers = {"Content-Type": "text/html; charset=utf-8", "Content-Security-Policy": policy}
        route.fulfill(body=_document(pair, kind), headers=headers)

    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.route("**/*", answer)
    page.goto("https://sandbox.test/")
    views = page.locator(".qgeo-view")
    views.nth(1).wait_for()
    tools.until(lambda: tools.pixels(views.nth(1)).std() > 15)
    before = tools.settled(views.first)

    page.evaluate("change()")
    tools.until(lambda: np.abs(tools.pixels(views.first) - before).mean() > 3)
    picture = tools.settled(views.first)
    half = picture.shape[1] // 2
    red, blue = picture[..., 0] - picture[..., 2] > 60, picture[..., 2] - picture[..., 0] > 60
    assert red[:, :half].mean() > 0.2
    assert blue[:, half:].mean() > 0.2

    box = views.first.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    (sent,) = page.evaluate("sent")
    assert (sent["kind"], sent["pane"], len(sent["corners"]), len(sent["point"])) == ("pick", 0, 3, 3)
    page.evaluate("end()")
    assert views.count() == 0
    assert asked == ["https://sandbox.test/"]
    assert not [line for line in said if "GPU stall" not in line and "GL Driver" not in line]
