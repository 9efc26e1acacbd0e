"""Kernels, in reading order: tracking. Each stands on those before it.

- lanes_nb: Newton's method on many points of one element at once: the fast lane of tracking
- bins_nb: rows in the order of their elements: what lanes are handed of them, and what these find
- onward_nb: where Newton's method goes on when it leaves an element
- lane_proof_nb: the quick certificate of many feet of one element at once
- mixed_lanes_nb: lanes of an element each: feet that have left their element, and those of
  elements that have few
- project_nb: the outer loops of tracking: ranges of rows, each row solved on its own
- track_nb: tracking whole: chunks of points, each from binning to the certificates of its feet
- row_nb: tracking one point by itself: what a thread of a GPU does
"""
