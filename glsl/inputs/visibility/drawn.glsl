// The mesh as it is drawn.
uniform samplerBuffer drawn_vertices;  // three texels a vertex: position and normal, each with a lift; tangent
uniform isamplerBuffer drawn_corners;  // three a triangle
