"""Kernels of contact areas, in reading order: each depends on the ones before it only.

- components_nb: connected components of points in contact
- chain_nb: closed lines from segments
- facet_area_nb: facets that touch in part: their cut at the edge of contact, and the area of the
  part in contact
- hull_nb: convex hull by Jarvis' march
- touch_nb: facets that touch, with all or with some of their corners
- image_nb: area of the image of facets on the master, whole or cut, from feet and normals
"""
