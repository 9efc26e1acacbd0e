"""Shaded pictures of triangles, lines and points: a camera, a z-buffer, light. They take arrays only.

`camera` places the eye, `shading` draws layers, `picture` makes a small PNG for a notebook. Reports,
previews and films compose their views of these.
"""
