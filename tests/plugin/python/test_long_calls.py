# SPDX-License-Identifier: Apache-2.0
"""Long calls: they release the GIL, report progress, stop when asked, leave nothing behind, and may
run side by side."""
import os
import signal
import subprocess
import sys
import textwrap
import threading

import numpy as np
import pytest

import octetvdb
from conftest import box_mesh, fluxes


def test_progress_counts_up_and_finishes(tmp_path, flow_asset):
    reports = []
    octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=24,
                  progress=lambda *report: reports.append(report))
    assert {type(x) for report in reports for x in report} == {str, int}
    stages = {}
    for stage, done, total, unit in reports:
        assert 0 <= done <= total and unit
        assert stages.get(stage, (0,))[0] <= done
        stages[stage] = done, total
    assert any(stage.startswith("build") for stage in stages)
    assert all(done == total for done, total in stages.values()), stages


@pytest.mark.parametrize("answer", [True, None, 1, 0, "stop"])
def test_only_false_cancels(tmp_path, flow_asset, answer):
    octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=8,
                  progress=lambda *report: answer)
    assert os.listdir(tmp_path) == ["a.vdb"]


def calls_of_a_bake(asset, folder):
    """How many different reports there are; long steps repeat theirs."""
    reports = []
    octetvdb.bake(asset, os.path.join(folder, "count.vdb"), resolution=24,
                  progress=lambda *report: reports.append(report))
    os.remove(os.path.join(folder, "count.vdb"))
    return 1 + sum(a != b for a, b in zip(reports, reports[1:]))


def test_cancelling_at_any_report_leaves_nothing(tmp_path, flow_asset):
    total = calls_of_a_bake(flow_asset, tmp_path)
    assert total >= 3
    for stop_at in range(total):
        calls, last = [0], [None]

        def progress(*report):
            calls[0] += report != last[0]
            last[0] = report
            return calls[0] <= stop_at
        with pytest.raises(octetvdb.Cancelled):
            octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=24, progress=progress)
        assert calls[0] == stop_at + 1
        assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError, SystemExit])
def test_what_the_callback_raises_comes_out(tmp_path, flow_asset, error):
    def progress(*report):
        raise error("from the callback")
    with pytest.raises(error, match="from the callback"):
        octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=8, progress=progress)
    with pytest.raises(error, match="from the callback"):
        octetvdb.Refiner(flow_asset.mesh, 2, progress=progress)
    refiner = octetvdb.Refiner(flow_asset.mesh, 2)
    with pytest.raises(error, match="from the callback"):
        refiner.refine(2, fluxes(flow_asset.mesh), progress=progress)
    assert os.listdir(tmp_path) == []


def test_a_callback_that_is_none_is_refused(tmp_path, flow_asset):
    with pytest.raises(TypeError, match="callable"):
        octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=8, progress=3)
    with pytest.raises(TypeError):
        octetvdb.bake(flow_asset, str(tmp_path / "a.vdb"), resolution=8, progress=lambda: True)
    assert os.listdir(tmp_path) == []


def test_ctrl_c_cancels_without_a_callback(tmp_path):
    """A bake that would take minutes, in a process of its own, ends by SIGINT."""
    script = textwrap.dedent("""
        import signal, sys, threading, os
        sys.path[:0] = sys.argv[2:]
        from conftest import box_mesh, fluxes
        import octetvdb
        mesh = box_mesh((4, 4, 4))
        asset = octetvdb.ControlAsset(mesh, [octetvdb.Form(mesh, "flow", 2, fluxes(mesh))])
        threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            octetvdb.bake(asset, sys.argv[1], resolution=700, levels=4)
        except KeyboardInterrupt:
            print("interrupted")
    """)
    here = os.path.dirname(os.path.abspath(__file__))
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path / "a.vdb"), here],
                          capture_output=True, text=True, timeout=120)
    assert done.stdout == "interrupted\n", done.stderr
    assert os.listdir(tmp_path) == []


def test_the_gil_is_free_while_it_works(box):
    """Another thread of Python runs during the call, again and again."""
    ticks, stop, at_start = [0], threading.Event(), []

    def tick():
        while not stop.is_set():
            ticks[0] += 1
            stop.wait(0.001)
    ticker = threading.Thread(target=tick)
    switch = sys.getswitchinterval()
    sys.setswitchinterval(1000)  # nobody is made to give the GIL away
    try:
        ticker.start()
        at_start.append(ticks[0])
        octetvdb.Refiner(box, 4)
        during = ticks[0] - at_start[0]
    finally:
        stop.set()
        sys.setswitchinterval(switch)
        ticker.join()
    assert during >= 5


def test_calls_side_by_side_give_the_same(tmp_path, box):
    """Shared mesh, refiner, limit and field; with callbacks that need the GIL."""
    w = fluxes(box)
    refiner = octetvdb.Refiner(box, 3)
    asset = octetvdb.ControlAsset(box, [octetvdb.Form(box, "flow", 2, w)])
    points = np.random.default_rng(6).uniform(-0.7, 0.7, (2000, 3))
    field = refiner.field(2, w)
    expected = refiner.refine(2, w), field.sample(points)[0], octetvdb.Refiner(box, 2).positions()
    fresh = octetvdb.Refiner(box, 3)  # its limit is made by whoever comes first
    fresh_field = octetvdb.Refiner(box, 3).field(2, w)
    errors, start = [], threading.Barrier(6)

    def work(k):
        try:
            start.wait()
            assert np.array_equal(fresh_field.sample(points)[0], expected[1])
            assert np.array_equal(fresh.field(2, w).sample(points)[0], expected[1])
            assert np.array_equal(refiner.refine(2, w), expected[0])
            mine = octetvdb.Refiner(box, 2, progress=lambda *report: True)
            assert np.array_equal(mine.positions(), expected[2])
            octetvdb.bake(asset, str(tmp_path / f"{k}.vdb"), resolution=16,
                          progress=lambda *report: True)
        except BaseException as error:  # noqa: B902 - told to the main thread
            errors.append(error)
    threads = [threading.Thread(target=work, args=(k,)) for k in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=120)
        assert not thread.is_alive(), "deadlock"
    assert not errors, errors
    sizes = {info.active_voxels for k in range(6)
             for info in octetvdb.read_grid_info(str(tmp_path / f"{k}.vdb"))}
    assert len(sizes) == 1


def test_one_bake_is_cancelled_the_others_go_on(tmp_path, flow_asset):
    outcome = {}

    def work(k):
        try:
            octetvdb.bake(flow_asset, str(tmp_path / f"{k}.vdb"), resolution=24,
                          progress=lambda *report: k != 1)
            outcome[k] = "done"
        except octetvdb.Cancelled:
            outcome[k] = "cancelled"
    threads = [threading.Thread(target=work, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    assert outcome == {0: "done", 1: "cancelled", 2: "done"}
    assert sorted(os.listdir(tmp_path)) == ["0.vdb", "2.vdb"]


def test_threads_do_not_change_results(tmp_path):
    mesh = box_mesh((3, 3, 3))
    w = fluxes(mesh)
    results = []
    for threads in (1, 2, 5):
        with octetvdb.ThreadLimit(threads):
            results.append(octetvdb.Refiner(mesh, 3).refine(2, w))
    assert all(np.array_equal(results[0], r) for r in results)
    with pytest.raises(octetvdb.InputError):
        octetvdb.ThreadLimit(0)


def test_signal_handlers_are_left_alone():
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
