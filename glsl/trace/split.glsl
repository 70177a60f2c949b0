// Where a large node of the kd-tree is split. A plane is (n, p): the points with dot(x, n) = p, n the unit vector of an
// axis; dot(x, n) reads a component faster than x[axis] does.   [Zhou et al. 2008, section 3.1]   Twin: glcloth/reference/split.py

// [Zhou et al. 2008, section 3.1]  The middle of the longest axis of a box; x before y before z when they are alike.
vec4 middle_plane(vec3 low, vec3 high) {
    vec3 e = high - low;
    vec3 n = e.z > max(e.x, e.y) ? vec3(0.0, 0.0, 1.0) : e.y > e.x ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
    return vec4(n, dot(n, 0.5 * (low + high)));
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
