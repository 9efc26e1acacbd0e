"""The suite `closed_forms`: what moves by forces, and its numbers, against formulas."""
