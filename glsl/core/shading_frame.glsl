// Frames of shading.   Twin: glcloth/twins/shading_frame.py

// [own]  The smooth normal, bent just enough that its cosine to omega_o is `least`. At silhouettes interpolated normals
// turn away from the viewer; a pixel that is seen cannot have its viewer below the horizon, or it would be black.
vec3 facing_normal(vec3 N, vec3 omega_o, float least) {
    float cos_no = dot(N, omega_o);
    if (cos_no >= least) return N;
    // The part of N across omega_o keeps its direction; where N is opposite to omega_o there is none, and omega_o serves.
    vec3 across = N - cos_no * omega_o;
    float length_2 = dot(across, across);
    if (length_2 < 1e-12) return omega_o;
    return across * sqrt((1.0 - least * least) / length_2) + least * omega_o;
}

// [own]  The direction d mirrored at the smooth normal, or at the geometric one N_g where that would go into the surface.
vec3 mirrored_direction(vec3 d, vec3 N, vec3 N_g) {
    vec3 r = reflect(d, N);
    return dot(r, N_g) > 0.0 ? r : reflect(d, N_g);
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
