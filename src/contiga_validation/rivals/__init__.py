"""The suite of rivals: exact geometry against meshes, ours and those of other libraries."""
