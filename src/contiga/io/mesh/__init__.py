"""Files of meshes and clouds, and series of them."""
