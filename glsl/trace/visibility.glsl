// What a point sees of its surroundings.   Twin: glcloth/reference/visibility.py

// [McTaggart 2004, the ambient cube]  A value over directions from its means about the six axes.
float from_cube(vec3 omega, vec3 plus, vec3 minus) {
    return dot(omega * omega, mix(minus, plus, greaterThan(omega, vec3(0.0))));
}

// [own]  One diffuse bounce: what hides the light is cloth of albedo rho, lit about as the point itself.
vec3 bounced(vec3 L, vec3 rho, float V_0) {
    return L * (1.0 + rho * (1.0 - V_0));
}
