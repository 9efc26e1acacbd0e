"""Kernels, in reading order: certificates of tracked feet. Each stands on those before it.

- rest_nb: what an element's surface leaves its second-order Taylor polynomial by, over a box
- bend_nb: how much an element bends over a box: rigorous bounds of its normal curvatures and
  widths
- pole_nb: how much an element bends over a box with a side that is one point, as at the pole of a
  sphere
- part_nb: parts of elements, sixteen each, and what the record of a neighbourhood takes over of one
- wide_neighbourhood_nb: surroundings of parts beside which elements are narrow: whole rows and
  columns of parts
- neighbourhood_nb: bounds around every sixteenth of an element
- branch_nb: the certificate of a tracked foot: that it is on the branch its start was on
"""
