"""Compilation, caching and calls of kernels: the one room that uses numba's extension points.

It uses numba as it is: nothing of numba, llvmlite or Python is changed for other packages.
Kernels import the decorators. The modules in reading order, each uses those before it:

- stamps: hashes of source files and of all that they import, which identify cached kernels
- locks: one process at a time for work that several would do
- folder: the folder of cached kernels, and its size
- prebuilt, vectors: installed kernels, and the constants of kernels that depend on the processor
- cache: the files of kernels, numba's own with our stamps and locks
- scratch, block, prefetch: instructions in kernels that Python has no word for
- libraries: code that is linked into its callers, and code that is called
- reference_counts, pipeline: numba's passes, and three of our own
- dispatcher: kernels with one version for all integer types
- reference: named tuples of tables, passed by pointer
- decorators: `kernel`, `inner`, `inlined`, `straight`
- preload: loading of kernels from their files ahead of their first call
"""

from contiga.jit.decorators import inlined as inlined
from contiga.jit.decorators import inner as inner
from contiga.jit.decorators import kernel as kernel
from contiga.jit.decorators import straight as straight
