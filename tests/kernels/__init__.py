"""The list of kernels that the package brings along: how it is made, and whether it is true."""
