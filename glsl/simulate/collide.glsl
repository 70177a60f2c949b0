// Signed distances to solids, and friction.  Twin: glcloth/twins/collide.py
// Each distance function returns (unit gradient, distance); outside is positive.

// [own] Half space below the plane dot(normal, p) = offset.
vec4 d_plane(vec3 p, vec3 normal, float offset) {
    return vec4(normal, dot(normal, p) - offset);
}

// [own] Ball. At its very centre the gradient is +Y.
vec4 d_sphere(vec3 p, vec3 center, float radius) {
    vec3 e = p - center;
    float l = length(e);
    return vec4(l > 0.0 ? e / l : vec3(0.0, 1.0, 0.0), l - radius);
}

// [own] Box with outer half sides half_size, whose edges and corners are rounded with `radius` <= min(half_size):
// the distance to the inner box, less the radius (Quilez, "3D distance functions", with the gradient).
vec4 d_box(vec3 p, vec3 center, vec3 half_size, float radius) {
    vec3 e = p - center;
    vec3 side = vec3(e.x < 0.0 ? -1.0 : 1.0, e.y < 0.0 ? -1.0 : 1.0, e.z < 0.0 ? -1.0 : 1.0);
    vec3 q = abs(e) - (half_size - vec3(radius));
    vec3 outer = max(q, vec3(0.0));
    float l = length(outer);
    if (l > 0.0) {
        return vec4(side * outer / l, l - radius);
    }
    // Inside the inner box the nearest face decides.
    float depth = max(q.x, max(q.y, q.z));
    vec3 face = q.x >= depth ? vec3(1.0, 0.0, 0.0) : q.y >= depth ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    return vec4(side * face, depth - radius);
}

// [own] Ellipsoid with half axes `axes`: to first order the distance, |p / axes| (|p / axes| - 1) / |p / axes^2| (Quilez,
// "3D distance functions"), exact on its surface. At its very centre the gradient is +Y.
vec4 d_ellipsoid(vec3 p, vec3 center, vec3 axes) {
    vec3 e = (p - center) / axes;
    vec3 n = e / axes;
    float k = length(e), l = length(n);
    return l > 0.0 ? vec4(n / l, k * (k - 1.0) / l) : vec4(0.0, 1.0, 0.0, -min(axes.x, min(axes.y, axes.z)));
}

// [own] Coulomb friction on positions: `slide` is how far the point slid along the surface in this substep, `push` > 0
// how far it was pushed out; both come from the same impulse's time step, so |friction| <= mu |normal force| reads
// |correction| <= mu push (Mueller, Heidelberger, Hennix, Ratcliff 2007, "Position based dynamics", section 3.6, as a
// bound). Returns the correction, at most -slide.
vec3 friction(vec3 slide, float push, float mu) {
    float l = length(slide);
    return l > 0.0 ? slide * -min(1.0, mu * push / l) : vec3(0.0);
}
