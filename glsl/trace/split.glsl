// Where a large node of the kd-tree is split. A plane is (n, p): the points with dot(x, n) = p, n the unit vector of an
// axis; dot(x, n) reads a component faster than x[axis] does.   [Zhou et al. 2008, section 3.1]   Twin: glcloth/reference/split.py

// [own]  Of the planes through the middle of a box, across x, y and z, the one whose halves cost least by the surface area
// heuristic; `counts` are the references that the two halves of each hold together. [Zhou et al. 2008] take the longest axis.
vec4 cheapest_middle(vec3 low, vec3 high, vec3 counts) {
    vec3 e = high - low;
    vec3 middle = 0.5 * (low + high);
    vec3 half_area = e.yzx * e.zxy + 0.5 * e * (e.yzx + e.zxy);
    vec3 cost = counts * half_area;
    // No plane parts a box that is flat across it.
    cost = mix(cost, vec3(3e38), vec3(lessThanEqual(e, vec3(0.0))));
    vec3 n = cost.x <= min(cost.y, cost.z) ? vec3(1.0, 0.0, 0.0) : cost.y <= cost.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    return vec4(n, dot(n, middle));
}

// [own]  As `sides`, for the planes across x, y and z through one point: (left of each, right of each) as 0 or 1.
mat2x3 sides_of_middle(vec3 low, vec3 high, vec3 middle) {
    vec3 right = vec3(greaterThan(high, middle));
    return mat2x3(max(vec3(lessThan(low, middle)), 1.0 - right), right);
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
