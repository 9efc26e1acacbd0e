"""Find where the faces of a body meet, and whether any border is open.

Question: is the body closed, and how far are its faces apart where they meet? Asked with `Faces`;
answered by `Openings`. Read `openings`, `meetings` (borders along one another), `crossings` (faces
that go through one another), `coincident` (faces that lie on one another).
"""
