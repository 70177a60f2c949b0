// The frame of one tangent of a yarn.   [Miz section 1.2, facts of the model in SYMBOLS.md]
// Surface frame: x = yarn 1, y = yarn 2, z = N. Twin: glcloth/twins/frame.py

// [own]  (omega . t, omega . b, omega . n) of a direction in the surface frame, for a tangent of yarn 0 or 1 that is
// tilted by an angle toward -N:
//   yarn 0: t = (cos, 0, -sin), n = (sin, 0, cos), b = n x t = (0, 1, 0)
//   yarn 1: t = (0, cos, -sin), n = (0, sin, cos), b = n x t = (-1, 0, 0)
vec3 tangent_from_surface(vec3 omega, int yarn, float cos_tilt, float sin_tilt) {
    float along = yarn == 0 ? omega.x : omega.y;
    float across = yarn == 0 ? omega.y : -omega.x;
    return vec3(along * cos_tilt - omega.z * sin_tilt, across, along * sin_tilt + omega.z * cos_tilt);
}
