"""What the tests of written files share."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from contiga.io.out.vtkhdf_layout import Growing


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, Callable[[], None]], None]:
    """Has a step stopped, as by Ctrl-C, behind so many of the arrays that it writes."""

    def stop(after: int, step: Callable[[], None]) -> None:
        own, left = Growing.put, [after]

        def put(self: Growing, start: int, values: object) -> None:
            left[0] -= 1
            if left[0] < 0:
                raise KeyboardInterrupt
            own(self, start, values)

        with monkeypatch.context() as patch:
            patch.setattr(Growing, "put", put)
            with pytest.raises(KeyboardInterrupt):
                step()

    return stop
