"""Kernels, in reading order: contact areas. Each stands on those before it.

- components_nb: connected components of points in contact
- chain_nb: closed lines from segments, gone along from node to node
- facet_area_nb: facets that touch in part: their cut at the edge of contact, and the area of what
  is left
- hull_nb: convex hull by Jarvis' march
- touch_nb: facets that touch, told apart by how many of their corners do
- image_nb: the image of facets on the master, whole or cut, measured in space from feet and
  normals
"""
