"""Kernels of the forces of matter, in reading order. Each uses those before it.

- lanes_nb: blocks of elements: corners gathered to lanes, forces of lanes summed at nodes
- solid_nb: tetrahedra: the gradient of a deformation, and forces from its stress
- solid_hex_nb: hexahedra: their mean gradient, and springs against hourglass modes
- membrane_nb: membranes: the gradient and strain of triangles, and forces from their stress
- solid_elastic_nb: Saint-Venant-Kirchhoff solid: stress and energy of a gradient
- solid_neo_hooke_nb: Neo-Hookean solid
- solid_principal_nb: principal stretches
- solid_foam_nb: low-density foam, with rates and unloading
- solid_viscosity_nb: bulk viscosity
- membrane_elastic_nb: plane stress, with and without compression
- membrane_neo_hooke_nb: Neo-Hookean membrane
- membrane_fabric_nb: woven fabric
- membrane_tangent_nb: tangents of membranes, or upper bounds of them
- membrane_rows_nb: row sums of the stiffness of triangles
- bar_nb: bars of two nodes
- elements_stress_nb: dispatch to the stage of the material
- elements_nb: forces of elements, block by block
- row_sums_nb: row sums of the stiffness of elements, block by block
- shell_nb: Kirchhoff-Love shells of splines: strains of a Gauss point, and forces of its stresses
- shell_elements_nb: forces of shells, block by block
- shell_tangent_nb: stiffness of shells, and its row sums
- shell_slope_nb: springs that hold the slope between patches of shells
"""
