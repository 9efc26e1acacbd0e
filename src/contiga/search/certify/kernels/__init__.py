"""Kernels of certificates of tracked feet, in reading order: each depends on the ones before it.

- remainder_nb: bounds of the second-order Taylor remainder of an element over a box
- bend_nb: rigorous bounds of an element's normal curvatures and widths over a box
- pole_nb: the same over a box with a side that is one point, as at the pole of a sphere
- part_nb: parts of elements, sixteen each, and the contribution of a part to a neighbourhood
- wide_neighbourhood_nb: neighbourhoods of parts next to narrow elements: complete rows and columns
  of parts
- neighbourhood_nb: bounds around every sixteenth of an element
- branch_nb: the certificate of a tracked foot: that it is on the branch its start was on
"""
