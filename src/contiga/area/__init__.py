"""Contact area of the points that touch."""
