// Unit vectors as points of a square.   [Cigolle et al. 2014, "A survey of efficient representations for unit vectors"]
// Twin: glcloth/twins/octahedron.py

// [Cigolle 2014]  The point in [-1, 1]^2 of a vector of any length but 0: the octahedron unfolded.
vec2 octahedral(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z < 0.0 ? folded : p;
}

// [Cigolle 2014]  The unit vector of a point in [-1, 1]^2.
vec3 from_octahedral(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float t = max(-n.z, 0.0);
    n.xy -= vec2(n.x >= 0.0 ? t : -t, n.y >= 0.0 ? t : -t);
    return normalize(n);
}
