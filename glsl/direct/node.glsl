// Nodes of a spherical Gaussian: where they stand in its table, and their directions.   [own]
// Twin: glcloth/twins/node.py
#include "core/math.glsl"

// [own]  The place in 0..1 of an axis at an angle from N, 0..pi, in tables that are dense about the horizon: over `width`
// radians a Gaussian sinks below it, elsewhere its nodes only follow its axis.
float column_of(float angle, float width) {
    float reach = atan(0.5 * PI / width);
    return 0.5 + 0.5 * atan((angle - 0.5 * PI) / width) / reach;
}

// [own]  The horizontal unit direction under xi; (1, 0) at the zenith.
vec2 azimuth(vec3 xi) {
    float h = length(xi.xy);
    return h > 1e-5 ? xi.xy / h : vec2(1.0, 0.0);
}

// [own]  a u + b v + c xi of a node (a, b, c), with e = azimuth(xi), u = N x e and v = d xi / d angle.
vec3 direction_from_node(vec3 node, vec3 xi, vec2 e) {
    float h = dot(xi.xy, e);
    return node.x * vec3(-e.y, e.x, 0.0) + node.y * vec3(xi.z * e, -h) + node.z * xi;
}
