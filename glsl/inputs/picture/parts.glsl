// Parts of a pixel's light that are wanted by themselves: for the layers of a picture, of programs with PARTS, and for a ground
// that shows its shadow alone, of programs with CATCHER. What adds light of a kind says so here; 0 is none.
vec3 L_bounce = vec3(0.0);   // came back from a surface, of `L_o` or of `irradiance`
bool came_back = false;      // whether the last flux of "along.glsl" did
vec3 let_on = vec3(0.0);     // of such a flux what cloth on the way let on of the light itself
vec3 E_hidden = vec3(0.0);   // irradiance that something hides, of `irradiance`
#if defined(PARTS) && defined(COVERED)
vec4 bounce_color, through_color;  // as inputs/picture/output.glsl has the whole
#elif defined(PARTS)
layout(location = 1) out vec4 bounce_color;
layout(location = 2) out vec4 through_color;
#endif
