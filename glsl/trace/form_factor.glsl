// Form factors from a point to polygons: the share of the light that leaves the point's surface, evenly over its hemisphere,
// which meets the polygon.   [Lambert 1760; Baum, Rushmeier, Winget 1989, "Improving radiosity solutions through the use of
// analytically determined form-factors"]   Corners are relative to the point; n is its unit normal.
// Twin: glcloth/twins/form_factor.py

// [own]  The angle between a and b whose cross product is l long, 0 to pi: by an eighth of it and six terms of arctan's
// series, because a driver's atan may have five digits only, and a factor is a small difference of angles.
float angle_of(float l, vec3 a, vec3 b) {
    float half_tan = l / max(length(a) * length(b) + dot(a, b), 1e-9 * l + 1e-30);
    float quarter = half_tan / (1.0 + sqrt(1.0 + half_tan * half_tan));
    float x = quarter / (1.0 + sqrt(1.0 + quarter * quarter));
    float y = x * x;
    return 8.0 * x * (1.0 - y * (1.0 / 3.0 - y * (1.0 / 5.0 - y * (1.0 / 7.0 - y * (1.0 / 9.0 - y * (1.0 / 11.0 - y / 13.0))))));
}

// [Baum 1989, Eq. 7]  What the edge from a to b adds to 2 pi F.
float edge_factor(vec3 a, vec3 b, vec3 n) {
    vec3 c = cross(a, b);
    float l = length(c);
    return l > 1e-12 ? angle_of(l, a, b) * dot(c, n) / l : 0.0;
}

// [own]  Where the line through a and b meets the horizon of n; a where it runs along it.
vec3 horizon_point(vec3 a, vec3 b, vec3 n) {
    float z = dot(a, n);
    float fall = z - dot(b, n);
    return a + (fall != 0.0 ? z / fall : 0.0) * (b - a);
}

// [own]  `edge_factor` of the part of the edge above the horizon.
float clipped_edge_factor(vec3 a, vec3 b, vec3 n) {
    bool a_up = dot(a, n) >= 0.0;
    bool b_up = dot(b, n) >= 0.0;
    vec3 m = horizon_point(a, b, n);
    return a_up || b_up ? edge_factor(a_up ? a : m, b_up ? b : m, n) : 0.0;
}

// [own]  The factor of a flat convex quadrilateral, counter-clockwise seen from the point; c = d makes it a triangle. The part
// below the horizon is cut off, and the edge along the horizon that closes the rest counts.
float quad_factor(vec3 a, vec3 b, vec3 c, vec3 d, vec3 n) {
    vec4 z = vec4(dot(a, n), dot(b, n), dot(c, n), dot(d, n));
    bvec4 up = greaterThanEqual(z, vec4(0.0));
    vec3 ab = horizon_point(a, b, n);
    vec3 bc = horizon_point(b, c, n);
    vec3 cd = horizon_point(c, d, n);
    vec3 da = horizon_point(d, a, n);
    vec3 left = up.x && !up.y ? ab : up.y && !up.z ? bc : up.z && !up.w ? cd : da;
    vec3 entered = !up.x && up.y ? ab : !up.y && up.z ? bc : !up.z && up.w ? cd : da;
    float sum = clipped_edge_factor(a, b, n) + clipped_edge_factor(b, c, n) + clipped_edge_factor(c, d, n)
                + clipped_edge_factor(d, a, n);
    sum += any(up) && !all(up) ? edge_factor(left, entered, n) : 0.0;
    return max(-sum, 0.0) / 6.283185307179586;
}

// [own]  By what of values known at the leans 0, 0.1, 0.25 and 0.5 one at another lean is interpolated: by parabolas through three.
vec4 lean_weights(float lean) {
    float s = clamp(lean, -0.02, 0.5);
    bool low = s < 0.25;
    float a = low ? 0.0 : 0.1;
    float b = low ? 0.1 : 0.25;
    float c = low ? 0.25 : 0.5;
    vec3 w = vec3((s - b) * (s - c) / ((a - b) * (a - c)), (s - a) * (s - c) / ((b - a) * (b - c)), (s - a) * (s - b) / ((c - a) * (c - b)));
    return low ? vec4(w, 0.0) : vec4(0.0, w);
}
