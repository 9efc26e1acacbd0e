"""CAD files: STEP, IGES, 3DM, G+Smo."""
