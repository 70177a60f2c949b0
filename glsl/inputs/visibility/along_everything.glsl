// The light of a direction where nothing hides it: "along.glsl" without shadows.
vec3 flux_along(vec3 origin, vec4 direction, vec4 light) { return light.rgb; }
