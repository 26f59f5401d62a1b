"""Long work shows how far it has come, ends when it is cancelled, and leaves what was there."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import qgeo_widgets as qw
from qgeo_filters.filters import stages
from qgeo_filters.parallel import in_threads, run_tasks, watched
from qgeo_widgets import long_work, matrix_widget, shape
from qgeo_widgets.compare_widget import CARRIED
from qgeo_widgets.long_work import CancelledWorkError, LongWork


@pytest.fixture
def slow(monkeypatch):
    """A symmetry and a spectrum whose computation waits between its steps, and for ever."""
    begun = threading.Event()

    def forever(*args, **options):
        begun.set()
        in_threads(lambda _: threading.Event().wait(0.02), range(3000), 1, description="step")
        raise AssertionError("it was not cancelled")

    monkeypatch.setattr(shape, "QUICK", 10)
    monkeypatch.setattr(stages, "symmetry_of", forever)
    monkeypatch.setattr(stages, "spectrum_of", forever)
    return begun


@pytest.mark.parametrize("workers", [1, 3])
def test_a_watcher_hears_of_each_step_and_may_end_the_work(workers):
    heard = []
    with watched(lambda *step: heard.append(step)):
        in_threads(lambda item: item, range(4), workers, description="paths")
        run_tasks(lambda part: part, [3, 4], workers, progress=False, before=1)
    assert heard == [("paths", k, 4) for k in (1, 2, 3, 4)] + [("distances", k, 3) for k in (2, 3)]
    in_threads(lambda item: item, range(4), workers)
    assert len(heard) == 6  # nobody watches any more
    done = []

    def work(item):
        done.append(item)
        threading.Event().wait(0.01)

    def stop(step, count, total):
        raise CancelledWorkError("enough")

    with watched(stop), pytest.raises(CancelledWorkError):
        in_threads(work, range(300), workers)
    assert len(done) < 100


def test_seeking_a_map_tells_its_distances_and_stages(pair, monkeypatch):
    """Though both shapes are prepared in threads of their own; the button ends those, too."""
    told, threads = [], set()

    def hear(*step):
        told.append(step)
        threads.add(threading.get_ident())

    monkeypatch.setattr(long_work, "watched", lambda _: watched(hear))
    x, y = (shape.with_vertices(1.25 * shape.vertices) for shape in pair[:2])  # not kept by another test
    qw.compare(x, y, progress=False).close()
    assert threads == {threading.get_ident()}
    assert {"distances", "search", "register", "matched"} <= {step for step, _, _ in told}
    assert all(0 < done <= total for _, done, total in told)

    def cancelled(step, done, total):
        raise CancelledWorkError(f"left at {step}")

    monkeypatch.setattr(long_work, "watched", lambda _: watched(cancelled))
    widget = qw.compare(*(shape.with_vertices(1.5 * shape.vertices) for shape in (x, y)), progress=False)
    assert widget.message.startswith("left at ")
    assert not any(thread.name.startswith("ThreadPool") for thread in threading.enumerate())
    widget.close()


@pytest.mark.parametrize("what", ["mirrored", "eigenfunction"])
def test_the_button_cancels_and_state_and_picture_stay(pair, slow, what):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    before = [pane.colors for pane in widget._viewer.panes]
    (tick,) = (child for child in widget.children[0].children if getattr(child, "description", "") == "mirrored")
    if what == "mirrored":
        tick.value = True
    else:
        widget._mode_list.value = "eigenfunction"
    assert slow.wait(20)
    assert widget._long.running
    threading.Event().wait(0.8)
    assert (widget._long.layout.display, widget._long.cancel_button.layout.display) == ("", "")
    assert "of 3000" in widget._long._text.value
    assert not widget._long.in_background("something else", lambda: None)
    widget._long.cancel_button.click()
    widget._long.join(20)
    assert "was cancelled" in widget.message
    assert (widget.flip, tick.value, widget.mode, widget._mode_list.value) == (False, False, CARRIED, CARRIED)
    assert widget._long.layout.display == "none"
    np.testing.assert_array_equal(widget.p2p, pair[2])
    for pane, colors in zip(widget._viewer.panes, before, strict=True):
        np.testing.assert_array_equal(pane.colors, colors)
    widget.close()


def test_the_notebooks_stop_button_leaves_a_sentence(pair, monkeypatch):
    def interrupted(*args, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(stages, "symmetry_of", interrupted)
    widget = qw.symmetry(pair[0])
    assert widget.message == "Finding the self-symmetry was cancelled."
    assert widget._long.layout.display == "none"
    widget.close()


def test_what_is_short_shows_no_line():
    line = LongWork()
    with line.during("Something"):
        in_threads(lambda item: item, range(3), 1)
        assert line.layout.display == "none"
    with line.during("Something long", at_once=True):
        assert line.layout.display == ""
        assert "stop button" in line._text.value
    assert line.layout.display == "none"
    line.close()


def test_rows_of_the_matrix_are_kept(pair, monkeypatch):
    calls = []
    original = matrix_widget.distances
    monkeypatch.setattr(matrix_widget, "distances", lambda *a, **k: calls.append(1) or original(*a, **k))
    for _ in range(2):
        widget = qw.matrix(pair[0].with_vertices(1.5 * pair[0].vertices))
        assert widget.message == ""
        widget.close()
    assert len(calls) == 1
