// The kinds of light that a camera ray brings; their sum is its radiance. glcloth/gpu/layout.py reads the constants.
const int DIRECT = 0;        // the lamp's, of the surface that the ray meets first
const int BOUNCE = 1;        // from around the room, or even light; and what cloth mirrors
const int THROUGH = 2;       // all that comes through cloth
const int BEYOND = 3;        // what is behind the scene
const int LIGHT_PARTS = 4;

layout(std430) buffer Parts { vec4 kinds[]; };  // LIGHT_PARTS for each ray
