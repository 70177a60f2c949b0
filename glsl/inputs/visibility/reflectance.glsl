// What the triangles about the cloth reflect: of each object's triangle, then of the ground's.
layout(binding = 14) uniform samplerBuffer reflectance_data;
