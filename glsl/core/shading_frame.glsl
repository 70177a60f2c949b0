// Frames of shading.   Twin: glcloth/reference/shading_frame.py

// [own]  The smooth normal, bent just enough that omega_o is not below it. At silhouettes interpolated normals turn
// away from the viewer; no pixel that is seen may have its viewer below the horizon, or it would be black.
vec3 facing_normal(vec3 N, vec3 omega_o) {
    const float least = 0.02;  // the cosine of 88.9 degrees
    float cos_no = dot(N, omega_o);
    return cos_no >= least ? N : normalize(N + (least - cos_no) * omega_o);
}

// [own]  The unit part of v that is perpendicular to the unit vector N; any perpendicular where v is along N or zero.
vec3 orthogonal_part(vec3 v, vec3 N) {
    vec3 x = v - dot(v, N) * N;
    if (dot(x, x) <= 1e-8 * dot(v, v)) {
        vec3 axis = abs(N.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
        x = axis - dot(axis, N) * N;
    }
    return normalize(x);
}
