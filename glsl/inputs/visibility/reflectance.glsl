// What the triangles about the cloth reflect: of each object's triangle, then of the ground's.
uniform samplerBuffer reflectance_data;
