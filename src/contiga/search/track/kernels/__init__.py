"""Kernels of tracking, in reading order: each depends on the ones before it only.

- lanes_nb: Newton's method on many points of one element at once, and the quick certificates of
  their feet
- bins_nb: rows in the order of their elements: the input and the results of lanes
- onward_nb: the element in which Newton's method continues when it leaves one
- mixed_lanes_nb: lanes of different elements: feet that have left their element, and feet of
  elements with few points
- track_nb: complete tracking: chunks of points in lanes, and the stages for the other rows
- row_nb: tracking of a single point, as a thread of a GPU does it
"""
