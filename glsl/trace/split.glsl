// Where a large node of the kd-tree is split. A plane is (n, p): the points with dot(x, n) = p, n the unit vector of an
// axis; dot(x, n) reads a component faster than x[axis] does.   [Zhou et al. 2008, section 3.1]   Twin: glcloth/twins/split.py

// [own]  Where plane k of `count` lies in a box, as a fraction of it. Exact where count + 1 is a power of 2.
float plane_fraction(int k, int count) {
    return float(k + 1) / float(count + 1);
}

// [own]  The planes across x, y and z at a fraction of a box. Several passes ask, and must get the same to the last bit.
vec3 planes_at(vec3 low, vec3 high, float fraction) {
    precise vec3 planes = low + fraction * (high - low);
    return planes;
}

// [Mat 6]  Costs of splitting a box at each of these planes, by the surface area heuristic, times half the area of the
// box; `left` and `right` are the references in the parts. No plane parts a box that is flat across it.
vec3 plane_costs(vec3 low, vec3 high, float fraction, vec3 left, vec3 right) {
    vec3 e = high - low;
    vec3 face = e.yzx * e.zxy;
    vec3 rim = e * (e.yzx + e.zxy);
    vec3 cost = left * (face + fraction * rim) + right * (face + (1.0 - fraction) * rim);
    return mix(cost, vec3(3e38), vec3(lessThanEqual(e, vec3(0.0))));
}

// [own]  The unit vector of the axis along which a vector is least; x before y before z.
vec3 least_axis(vec3 v) {
    return v.x <= min(v.y, v.z) ? vec3(1.0, 0.0, 0.0) : v.y <= v.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
}

// [own]  As `sides`, for the planes across x, y and z through one point, ready to be added up: 1 for left, 65536 for right.
uvec3 side_counts(vec3 low, vec3 high, vec3 planes) {
    uvec3 right = uvec3(greaterThan(high, planes));
    return (uvec3(lessThan(low, planes)) | (1u - right)) + 65536u * right;
}

// [Zhou et al. 2008, section 3.1]  The plane that cuts off the widest empty side of a cell, of those wider than `share` of the
// cell's extent: [low, high] is the box of its content. n = 0 if there is none; n < 0 if the content lies below the plane.
vec4 gap_plane(vec3 cell_low, vec3 cell_high, vec3 low, vec3 high, float share) {
    vec3 scale = 1.0 / max(cell_high - cell_low, vec3(1e-30));
    vec3 below = (low - cell_low) * scale;
    vec3 above = (cell_high - high) * scale;
    vec3 gap = max(below, above);
    float widest = max(gap.x, max(gap.y, gap.z));
    if (!(widest > share)) return vec4(0.0);
    vec3 n = gap.x == widest ? vec3(1.0, 0.0, 0.0) : gap.y == widest ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    bool empty_below = dot(n, below) == widest;
    return empty_below ? vec4(n, dot(n, low)) : vec4(-n, dot(n, high));
}

// [own]  Which children a box belongs to, (left, right) as 0 or 1: right when it reaches beyond the plane, left when it
// begins before it or lies in it. Counting and sorting both ask this function, so that they agree.
vec2 sides(vec3 low, vec3 high, vec4 plane) {
    bool right = dot(high, plane.xyz) > plane.w;
    bool left = dot(low, plane.xyz) < plane.w || !right;
    return vec2(left ? 1.0 : 0.0, right ? 1.0 : 0.0);
}
