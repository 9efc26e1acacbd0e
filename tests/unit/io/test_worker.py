"""Files are read in a worker process: whatever a reader does there becomes one message."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning, FileError, InputError, MeshError
from contiga.io import worker
from contiga.io.worker import read_in_worker

posix = pytest.mark.skipif(os.name != "posix", reason="signals and bounds of POSIX")
linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux only")

READERS = """
import os, signal, sys, time, warnings
import numpy as np
from contiga.errors import ContigaWarning, MeshError

def plain(path, *args): return path.read_bytes(), args
def segfault(path): os.kill(os.getpid(), signal.SIGSEGV)
def leave(path): os._exit(3)
loaded = []
def warm_up():
    if os.environ.get("LARGE_READER"): loaded.append(b"1" * 250_000_000)
def spin(path):
    while True: pass
def sleep(path): time.sleep(1e6)
def tell_and_sleep(path):
    path.with_suffix(".group").write_text(str(os.getpgrp()))
    sleep(path)
def sleep_briefly(path): time.sleep(0.3); return 1
def swamp(path): return np.ones(10**10)
def many(path):
    kept = []
    while True: kept.append(bytearray(10**7))
def noisy(path):
    os.system("echo from a program; echo error >&2")
    print("text"); print("error", file=sys.stderr); os.write(1, b"bytes")
def refuse(path): raise MeshError("no good", where=str(path), found=3, allowed="4")
def refuse_oddly(path): raise MeshError("no good", where=str(path), found=lambda: 0)
def fail(path): raise KeyError("nodes")
def deep(path): return deep(path)
def warn(path):
    warnings.warn("half of it was left out", ContigaWarning)
    np.float64(1e300) * 1e300
    return 1
def number(path): return os.getpid()
def lacking(path):
    import a_library_nobody_has
def array(path): return np.arange(10.0) / 3.0
"""


@pytest.fixture(scope="session")
def readers(tmp_path_factory):
    folder = tmp_path_factory.mktemp("readers")
    (folder / "some_readers.py").write_text(READERS)
    return folder


@pytest.fixture
def path(tmp_path, readers, monkeypatch):
    monkeypatch.syspath_prepend(readers)
    monkeypatch.setenv("CONTIGA_READ_SECONDS", "1")
    monkeypatch.setenv("CONTIGA_READ_MEMORY", "300")
    file = tmp_path / "part.step"
    file.write_bytes(b"content")
    return file


def read(name, path, *args):
    return read_in_worker(f"some_readers:{name}", path, *args)


def test_what_a_reader_returns_comes_back(path):
    assert read("plain", path, "mm", None) == (b"content", ("mm", None))


@posix
@pytest.mark.parametrize(
    ("name", "said"),
    [("segfault", "crashed on this file .signal 11, SIGSEGV."), ("leave", "exit code 3")],
)
def test_a_reader_that_crashes_is_one_message_and_the_next_file_is_read(path, name, said):
    with pytest.raises(FileError, match=said) as caught:
        read(name, path)
    assert str(path) in str(caught.value)
    assert "damaged" in str(caught.value)
    assert caught.value.exit_code == 2
    assert read("plain", path)[0] == b"content"


@linux
def test_the_memory_of_a_readers_libraries_is_not_that_of_the_file(path, monkeypatch, no_worker):
    monkeypatch.setenv("LARGE_READER", "1")
    with pytest.raises(FileError, match="exit code 3"):
        read("leave", path)


@pytest.mark.parametrize("name", ["spin", "sleep"])
def test_a_reader_that_hangs_is_stopped(path, name):
    with pytest.raises(FileError, match=r"more than \d s .*CONTIGA_READ_SECONDS"):
        read(name, path)
    assert read("plain", path)[0] == b"content"


@linux
@pytest.mark.parametrize("name", ["swamp", "many"])
def test_a_reader_that_wants_too_much_memory_is_stopped(path, name):
    with pytest.raises(FileError, match=r"more than 300 MB .*CONTIGA_READ_MEMORY"):
        read(name, path)
    assert read("plain", path)[0] == b"content"


def test_nothing_a_reader_prints_is_seen(path, capfd):
    read("noisy", path)
    assert capfd.readouterr() == ("", "")


def test_what_a_reader_refuses_is_refused_in_its_words(path):
    with pytest.raises(MeshError) as caught:
        read("refuse", path)
    assert str(caught.value) == f"{path}: no good; found 3; allowed: 4"
    assert (caught.value.where, caught.value.found) == (str(path), 3)
    with pytest.raises(MeshError, match="no good; found <function"):
        read("refuse_oddly", path)


@pytest.mark.parametrize(("name", "said"), [("fail", "KeyError 'nodes'"), ("deep", "Recursion")])
def test_a_reader_that_fails_in_its_own_way_is_a_file_error(path, name, said):
    with pytest.raises(FileError, match=said) as caught:
        read(name, path)
    assert "some_readers.py" in str(caught.value.__cause__)  # for CONTIGA_DEBUG=1


def test_a_library_that_is_missing_is_named_as_such(path):
    with pytest.raises(ImportError, match="a_library_nobody_has"):
        read("lacking", path)
    with pytest.raises(ImportError, match="no_such_module"):
        read_in_worker("no_such_module:read", path)


def test_warnings_of_ours_are_passed_on_and_those_of_libraries_are_not(path):
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        assert read("warn", path) == 1
    assert [(w.category, str(w.message)) for w in heard] == [
        (ContigaWarning, "half of it was left out")
    ]


def test_arrays_come_back_bit_for_bit(path):
    assert (read("array", path) == np.arange(10.0) / 3.0).all()


@posix
def test_files_are_read_elsewhere_and_each_on_its_own(path):
    numbers = [read("number", path) for _ in range(3)]
    assert os.getpid() not in numbers
    if sys.platform == "linux":
        assert len(set(numbers)) == 3


def test_files_are_read_from_threads_at_the_same_time(path):
    with ThreadPoolExecutor(6) as pool:
        results = list(pool.map(lambda k: read("plain", path, k), range(24)))
    assert [args for _, args in results] == [(k,) for k in range(24)]


@posix
def test_ctrl_c_ends_the_reader_too(path, monkeypatch):
    monkeypatch.setenv("CONTIGA_READ_SECONDS", "600")
    assert read("plain", path)
    (child,) = worker._pool.workers[-1:]
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    # A shell that runs the tests in the background has Ctrl-C ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            read("sleep", path)
    finally:
        signal.signal(signal.SIGINT, before)
    assert child.process.poll() == -signal.SIGKILL
    assert is_cleared_away(child.process.pid)  # nor is anything left of what it had forked


def is_cleared_away(group: int) -> bool:
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


CALLER = """
import sys
from pathlib import Path
from contiga.io.worker import read_in_worker
read_in_worker("some_readers:tell_and_sleep", Path(sys.argv[1]))
"""


@linux
def test_a_caller_that_is_killed_leaves_no_reader(path, monkeypatch):
    monkeypatch.setenv("CONTIGA_READ_SECONDS", "600")
    folders = os.pathsep.join((str(Path(cg.__file__).parents[1]), *sys.path[:1]))
    env = {**os.environ, "PYTHONPATH": folders}
    caller = subprocess.Popen([sys.executable, "-c", CALLER, path], env=env)
    said = path.with_suffix(".group")
    while not said.exists() or not said.read_text():
        assert caller.poll() is None
        time.sleep(0.05)
    caller.kill()
    caller.wait()
    assert is_cleared_away(int(said.read_text()))


@posix
def test_a_forked_process_has_readers_of_its_own(path):
    assert read("plain", path)
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    process = context.Process(target=lambda: answers.put(read("plain", path, 7)), daemon=True)
    process.start()
    assert answers.get(timeout=120) == (b"content", (7,))
    process.join()
    assert read("plain", path, 8)[1] == (8,)


@posix
def test_a_worker_that_ended_for_want_of_work_is_replaced(path, no_worker):
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda _: read("sleep_briefly", path), range(2))) == [1, 1]
    assert len(no_worker.workers) == 2
    for ended in no_worker.workers:
        os.kill(ended.process.pid, signal.SIGKILL)
        ended.process.stdout.read()
    assert read("plain", path, 1)[1] == (1,)


@posix
def test_a_worker_without_work_ends(path, no_worker, monkeypatch):
    """The worker sets an alarm before it waits; here the alarm is sent."""
    assert read("plain", path)
    (waiting,) = no_worker.workers
    os.kill(waiting.process.pid, signal.SIGALRM)
    assert waiting.process.wait(10) == -signal.SIGALRM


@posix
def test_no_signal_comes_from_a_worker_that_has_ended(path, no_worker):
    """Where some library made the signal of a broken pipe deadly again, as gmsh does."""
    came = []
    before = signal.signal(signal.SIGPIPE, lambda *_: came.append(1))
    try:
        test_a_worker_that_ended_for_want_of_work_is_replaced(path, no_worker)
    finally:
        signal.signal(signal.SIGPIPE, before)
    assert came == []


@pytest.mark.parametrize("executable", ["", "/usr/bin/true", "missing/python3", "broken"])
def test_without_an_interpreter_files_are_read_in_process(path, tmp_path, monkeypatch, executable):
    if executable == "broken":
        program = tmp_path / "python3"
        program.write_text("#!/bin/sh\nexit 1\n")
        program.chmod(0o755)
        executable = str(program)
    monkeypatch.setattr(sys, "executable", executable)
    monkeypatch.setattr(worker, "_pool", worker._Pool())
    assert read("number", path) == os.getpid()
    with pytest.raises(FileError, match="KeyError 'nodes'"):
        read("fail", path)


@pytest.mark.parametrize("text", ["nought", "-3", "0", "nan", "inf"])
@pytest.mark.parametrize("name", ["CONTIGA_READ_SECONDS", "CONTIGA_READ_MEMORY"])
def test_bounds_that_are_none_are_named(path, monkeypatch, name, text):
    monkeypatch.setenv(name, text)
    with pytest.raises(InputError, match=f"{name}: must be a positive number; found '{text}'"):
        read("plain", path)


@pytest.fixture
def no_worker(monkeypatch):
    """Make this process one that has read nothing yet."""
    pool = worker._Pool()
    monkeypatch.setattr(worker, "_pool", pool)
    yield pool
    pool.end()


@posix
def test_a_reader_loaded_ahead_reads_the_next_file(path, no_worker):
    worker.prepare("some_readers:plain")
    worker.prepare("some_readers:plain")  # one is enough
    assert read("plain", path, 5) == (b"content", (5,))
    assert read("plain", path, 6)[1] == (6,)
    assert len(no_worker.workers) == 1


@posix
def test_a_reader_that_cannot_be_loaded_ahead_is_told_of_when_a_file_is_read(path, no_worker):
    worker.prepare("a_module_nobody_has:read")
    assert read("plain", path)
    with pytest.raises(ImportError, match="a_module_nobody_has"):
        read_in_worker("a_module_nobody_has:read", path)


SCRIPT = """
import sys, contiga
print(contiga.read_mesh(sys.argv[1]), "OCP" in sys.modules, "meshio" in sys.modules)
"""


def test_a_script_without_a_guard_reads_once_and_loads_no_reader(tmp_path):
    mesh = tmp_path / "plane.stl"
    cg.write_mesh(mesh, cg.shapes.plane().tessellate(1.0))
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    env = {**os.environ, "PYTHONPATH": str(Path(cg.__file__).parents[1])}
    done = subprocess.run(
        [sys.executable, script, mesh.name], cwd=tmp_path, env=env, capture_output=True, text=True
    )
    assert done.stderr == ""
    assert done.stdout.startswith("Slave('plane', points ")
    assert done.stdout.rstrip().endswith("False False")
    assert done.stdout.count("\n") == 1
