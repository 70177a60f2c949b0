// Constants and structs that Python and GLSL share; glcloth/gpu/layout.py reads this file, so it is the only place where
// they are written. Keep to `const`, and to structs of plain fields (std430).

const int MAX_TANGENTS = 32;  // distinct tangents of a fabric, both yarns together
const int MAX_LOBES = 64;     // spherical Gaussians of the environment, K   [Miz 7]
const int MAX_SUNS = 8;       // directional lights

// One of the two yarns of the weave.   [Miz 5]
struct Yarn {
    vec3 A;         // albedo, linear Rec. 709
    float eta;      // index of refraction
    float k_d;      // isotropic share of the volume term, 0..1
    float gamma_s;  // width of the surface lobe, radians
    float gamma_v;  // width of the volume lobe, radians
    float a;        // share of the weave's area
};

// One distinct tangent of a yarn, and its weights.   [Miz 6, erratum E7]
struct Tangent {
    float cos_tilt;
    float sin_tilt;
    float weight;  // its factor in the sum over tangents
    float share;   // its factor in W's normaliser
};

// One spherical Gaussian of the environment.   [Miz 1, 7]
struct Gaussian {
    vec3 xi;          // axis, toward the light
    float sharpness;  // 2 / sigma_k^2
    vec3 L;           // radiance at the axis, linear Rec. 709
    float spare;
};

// One directional light.
struct Sun {
    vec3 omega;       // toward the sun's middle
    float sin_radius; // of its disc
    vec3 E;           // irradiance on a surface that faces it, linear Rec. 709
    float spare_2;
};
