"""Ctrl-C that is never lost."""

from __future__ import annotations

import signal
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stoppable() -> Iterator[Callable[[], bool]]:
    """Ctrl-C that is not lost: yields a function that says whether there was one.

    Python drops an exception in the callback of a weak reference, and while kernels are loaded
    most of its own time goes by in these. There Ctrl-C is only noted, for the next step.
    """
    noted = False

    def note(_: int, frame: FrameType | None) -> None:
        nonlocal noted
        noted = True
        if frame is None or frame.f_code.co_filename != weakref.__file__:
            raise KeyboardInterrupt

    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if not ours:
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: noted
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
