"""Find where the faces of a body meet, and whether any border is open.

Question: is the body closed, and how far are its faces apart where they meet? The input is `Faces`,
the result is `Openings`. Read `openings`, `meetings` (pieces that touch or overlap), `crossings`
(faces that cross), `coincident` (faces that coincide).
"""
