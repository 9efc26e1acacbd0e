"""Handle Ctrl-C so that it is never lost."""

from __future__ import annotations

import signal
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stoppable() -> Iterator[Callable[[], bool]]:
    """Provide a function that returns whether Ctrl-C was pressed; no Ctrl-C is lost.

    Ctrl-C raises `KeyboardInterrupt` as usual. Only in the callback of a weak reference, where
    Python drops exceptions and spends most of its time while kernels are loaded, it is noted for
    the next step. In other threads than the main one, or beside another handler of SIGINT, nothing
    is changed and the function returns False.
    """
    is_stopped = False

    def handle(_: int, frame: FrameType | None) -> None:
        nonlocal is_stopped
        is_stopped = True
        if frame is None or frame.f_code.co_filename != weakref.__file__:
            raise KeyboardInterrupt

    can_handle = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if not can_handle:
        yield lambda: False
        return
    signal.signal(signal.SIGINT, handle)
    try:
        yield lambda: is_stopped
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
