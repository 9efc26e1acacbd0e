"""Shaded pictures of triangles, lines and points, from arrays alone.

`camera` places the eye, `shading` draws layers, `picture` makes a small PNG for a notebook.
Reports, previews and films are composed of these.
"""
