// Fresnel reflectance by Schlick's approximation.   [Miz 12, Mat 4]
// Twin: glcloth/twins/fresnel.py
#include "core/math.glsl"

// [Miz 12]  F_0 = ((1 - eta) / (1 + eta))^2, the reflectance at normal incidence.
float F_0(float eta) {
    float r = (1.0 - eta) / (1.0 + eta);
    return r * r;
}

// [Miz 12, Mat 4]  F_schlick = F_0 + (1 - F_0) (1 - cos_theta)^5
float F_schlick(float F_0, float cos_theta) {
    return F_0 + (1.0 - F_0) * pow5(1.0 - cos_theta);
}
