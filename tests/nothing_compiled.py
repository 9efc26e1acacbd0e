"""`python nothing_compiled.py`: the README's ten lines with installed kernels, and none compiled.

For an environment where contiga and a wheel of its kernels are installed, and pytest is not. Prints
what is used and the bits of the result, and ends with 1 if anything was compiled.
"""

from __future__ import annotations

import sys
from hashlib import sha256
from time import process_time
from typing import Any

from numba.core import event

import contiga as cg
from contiga.jit.prebuilt import choice


def pressed() -> Any:
    """The state at the end of the README's ten lines."""
    ball = cg.Body([cg.shapes.sphere(radius=20.0)])
    points = cg.clouds.sample(cg.shapes.plane(width=60.0, length=60.0), 61, 61)
    law = cg.ForceLaw([[0.0, 0.0], [5.0, 100.0]])
    contact = cg.Contact(ball, cg.Slave(points), law=law, area=cg.NodalArea(1.0))
    above, pressed = (cg.motion.pose.translation([0.0, 0.0, z]) for z in (21.0, 17.0))
    state = contact.start(points, pose=above)
    return contact.step(state, points, pose=pressed, dt=1.0)


def main() -> int:
    """Print it."""
    heard = event.RecordingListener()
    event.register("numba:compile", heard)
    state = pressed()
    compiled = sum(told.is_start for _, told in heard.buffer)
    bits = sha256(b"".join(a.tobytes() for a in (state.penetration, state.force, state.uv)))
    print(choice().text)
    print(f"{compiled} kernels compiled, {process_time():.1f} s, bits {bits.hexdigest()[:16]}")
    return 1 if compiled or choice().prebuilt is None else 0


if __name__ == "__main__":
    sys.exit(main())
