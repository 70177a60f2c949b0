// Reflectance of each object's triangles, then of the ground's.
uniform samplerBuffer reflectance_data;
