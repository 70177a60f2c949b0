// Rays against boxes and triangles, and triangles against planes.   Twin: glcloth/twins/intersect.py

// [own]  1 / d; a component of 0 becomes so small that its slab is met at once or never, and no 0 * inf arises.
vec3 safe_inverse(vec3 d) {
    return 1.0 / mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
}

// [Kay 1986, with Kajiya]  Where a ray enters and leaves a box, (t_0, t_1); it misses when t_0 > t_1.
vec2 slab(vec3 o, vec3 inv_d, vec3 low, vec3 high) {
    vec3 a = (low - o) * inv_d;
    vec3 b = (high - o) * inv_d;
    vec3 enter = min(a, b);
    vec3 leave = max(a, b);
    return vec2(max(max(enter.x, enter.y), enter.z), min(min(leave.x, leave.y), leave.z));
}

// [Woop et al. 2013, "Watertight ray/triangle intersection"]  The axis along which a direction is longest.
int longest_axis(vec3 d) {
    vec3 a = abs(d);
    return a.z >= max(a.x, a.y) ? 2 : a.x >= a.y ? 0 : 1;
}

// [Woop 2013]  v with the given axis last; cyclic, so that handedness is kept.
vec3 axis_last(vec3 v, int axis) {
    return axis == 2 ? v : axis == 0 ? v.yzx : v.zxy;
}

// [Woop 2013]  The shear (S_x, S_y, S_z) that turns a direction, its longest axis last, into (0, 0, 1).
vec3 shear_of(vec3 d) {
    return vec3(d.xy / d.z, 1.0 / d.z);
}

// [own]  Twice the signed area of the origin, p and q. By the sum and the difference of p and q: the difference keeps the
// digits of a short edge far from the origin, and with p and q exchanged the value is the negative to the last bit.
// `precise` forbids the fused operations that would break this.
float edge_function(vec2 p, vec2 q) {
    precise vec2 d = p - q;
    precise vec2 s = p + q;
    precise float f = d.x * s.y - d.y * s.x;
    return f;
}

// [Woop 2013]  A point, relative to the ray's origin and with the ray's longest axis last, seen along the ray.
vec2 sheared(vec3 p, vec3 shear) {
    precise vec2 s = p.xy - shear.xy * p.z;
    return s;
}

// [Woop 2013]  Where a ray meets a triangle: (t, v, w, determinant) from the three edge functions (opposite the first, the
// second and the third corner) and the depths of the corners along the longest axis; t = -1 for a miss.
// Two triangles that share an edge get opposite values of its edge function, so no ray slips through between them; a ray
// on the edge meets both.
vec4 hit_edges(vec3 edges, vec3 depths, vec3 shear) {
    float U = edges.x;
    float V = edges.y;
    float W = edges.z;
    float determinant = U + V + W;
    // All of one sign, the determinant's; -0 counts as 0. As integers, because comparisons of floats become minima that
    // have to mind NaN.
    uint sign = floatBitsToUint(determinant) & 0x80000000u;
    uvec3 e = floatBitsToUint(edges) ^ sign;
    bool miss = max(e.x, max(e.y, e.z)) > 0x80000000u || determinant == 0.0;
    float inverse = 1.0 / determinant;
    float t = (U * depths.x + V * depths.y + W * depths.z) * shear.z * inverse;
    return miss ? vec4(-1.0, 0.0, 0.0, 0.0) : vec4(t, V * inverse, W * inverse, 0.5 * determinant);
}

// [Woop 2013]  Where a ray meets the triangle a, b, c, given relative to the ray's origin and with the ray's longest axis
// last: (t, v, w, determinant) with the barycentric coordinates of b and c; t = -1 for a miss.
vec4 hit_triangle(vec3 a, vec3 b, vec3 c, vec3 shear) {
    vec2 A = sheared(a, shear);
    vec2 B = sheared(b, shear);
    vec2 C = sheared(c, shear);
    return hit_edges(vec3(edge_function(C, B), edge_function(A, C), edge_function(B, A)), vec3(a.z, b.z, c.z), shear);
}

// [own]  Where a ray goes on behind its hit at t. Hits within a hair of each other are the same layer's: two triangles
// that share an edge are both met there, at t that differ by rounding.
float behind_layer(float t) {
    return t + 1e-5 * (1.0 + t);
}

// [Zhou et al. 2008, section 3.1]  The box of the part of a triangle on one side of the plane dot(p, n) = plane
// (side = 1: below it, -1: above). Columns: low, high, (1 if there is such a part, 0, 0).
mat3 clipped_box(vec3 a, vec3 b, vec3 c, vec3 n, float plane, float side) {
    vec3 distance = side * (vec3(plane) - vec3(dot(a, n), dot(b, n), dot(c, n)));
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    if (distance.x >= 0.0) { low = min(low, a); high = max(high, a); }
    if (distance.y >= 0.0) { low = min(low, b); high = max(high, b); }
    if (distance.z >= 0.0) { low = min(low, c); high = max(high, c); }
    if ((distance.x < 0.0) != (distance.y < 0.0)) {
        vec3 p = mix(a, b, distance.x / (distance.x - distance.y));
        low = min(low, p); high = max(high, p);
    }
    if ((distance.y < 0.0) != (distance.z < 0.0)) {
        vec3 p = mix(b, c, distance.y / (distance.y - distance.z));
        low = min(low, p); high = max(high, p);
    }
    if ((distance.z < 0.0) != (distance.x < 0.0)) {
        vec3 p = mix(c, a, distance.z / (distance.z - distance.x));
        low = min(low, p); high = max(high, p);
    }
    bool some = low.x <= high.x;
    return mat3(some ? low : vec3(0.0), some ? high : vec3(0.0), vec3(some ? 1.0 : 0.0, 0.0, 0.0));
}
