// Directions within a texel of a cube map.
// Twin: glcloth/twins/cubemap.py

// [own] A place of the texel whose middle is `middle` and which covers `solid_angle`: at from -0.5 to 0.5 along its sides.
// Returns its direction, and the solid angle there per area beside that of the middle (a face is the plane |largest| = 1, and
// solid angle falls with the cube of the distance). All in the frame of the faces.
vec4 in_texel(vec3 middle, float solid_angle, vec2 at) {
    vec3 a = abs(middle);
    float m = max(a.x, max(a.y, a.z));
    float side = sqrt(solid_angle / (m * m * m));
    vec2 step = at * side;
    vec3 p = middle / m;
    if (a.x == m) p += vec3(0.0, step);
    else if (a.y == m) p += vec3(step.x, 0.0, step.y);
    else p += vec3(step, 0.0);
    float near = inversesqrt(dot(p, p)) / m;
    return vec4(p * (near * m), near * near * near);
}
