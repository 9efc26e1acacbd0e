"""Compilation, caching and calls of kernels: the one room that uses numba's extension points.

numba is as it comes, and stays so: nothing of it, of llvmlite or of Python is changed for others.
Kernels see the decorators; in reading order, each on those before it:

- stamps: hashes of source files and of all they import, which kept kernels are known by
- locks: one process at a time for what several would do
- folder: where kernels are kept, and how many
- prebuilt, vectors: kernels that were installed, and what of kernels depends on their level
- cache: kernels in files, numba's own with our stamps and locks
- scratch, block, prefetch: what kernels write and Python has no word for
- libraries: code that is linked into its callers, and code that is called
- uncounted, pipeline: numba's passes, and two of our own
- dispatcher: kernels of one version, whatever integers they are handed
- reference: named tuples of tables, passed by pointer
- decorators: `kernel`, `inner`, `inlined`, `straight`
- preload: kernels taken out of their files ahead of their first call
"""

from contiga.jit.decorators import inlined as inlined
from contiga.jit.decorators import inner as inner
from contiga.jit.decorators import kernel as kernel
from contiga.jit.decorators import straight as straight
