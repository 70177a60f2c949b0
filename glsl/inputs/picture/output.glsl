// What a pixel is shaded to: the colour of a fragment, or, in passes/picture/covered.comp, one that is stored.
#ifdef COVERED
vec4 color;
#else
layout(location = 0) out vec4 color;
#endif
