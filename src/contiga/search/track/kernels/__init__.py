"""Kernels, in reading order: tracking. Each stands on those before it.

- lanes_nb: Newton's method on many points of one element at once, and the quick certificates of
  their feet: the fast lane of tracking
- bins_nb: rows in the order of their elements: what lanes are handed of them, and what these find
- onward_nb: where Newton's method goes on when it leaves an element
- mixed_lanes_nb: lanes of an element each: feet that have left their element, and those of
  elements that have few
- track_nb: tracking whole: chunks of points in lanes, and the stages for the rows that are left
- row_nb: tracking one point by itself: what a thread of a GPU does
"""
