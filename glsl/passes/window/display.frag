#version 430
// A linear picture, or the difference of two, as codes for the screen: exposure and view transform.
// The transforms are those of glcloth/color.py, which cites them.
uniform sampler2D picture_a;
uniform sampler2D picture_b;
uniform vec2 extent;            // size of the result, pixels
uniform float exposure;         // stops
uniform int view_transform;     // 0 standard, 1 filmic, 2 neutral, 3 agx, 4 a table
uniform float difference_scale; // above 0: show |A - B| times this
uniform sampler3D config_view;   // of a config of OpenColorIO: glcloth/ocio.py `lut`
uniform bool opaque;            // the environment is behind the cloth
out vec4 color;

vec3 srgb_encode(vec3 x) {
    x = clamp(x, 0.0, 1.0);
    return mix(1.055 * pow(max(x, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

vec3 hable(vec3 x) {
    return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
}

vec3 neutral(vec3 c) {
    float x = min(c.r, min(c.g, c.b));
    c -= x <= 0.08 ? x - x * x / 0.16 : 0.04;
    float p = max(c.r, max(c.g, c.b));
    if (p <= 0.76) return c;
    float p_n = 1.0 - 0.24 * 0.24 / (p + 1.0 - 1.52);
    float g = 1.0 / (0.15 * (p - p_n) + 1.0);
    return c * (p_n / p) * g + p_n * (1.0 - g);
}

vec3 agx(vec3 rgb) {
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051, 0.0784335999999992,
                            0.878468636469772, 0.0784336, 0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438, -0.0980208811401368,
                             1.15190312990417, -0.0980434501171241, -0.0990297440797205, -0.0989611768448433,
                             1.15107367264116);
    vec3 v = log2(max(inset * rgb, vec3(exp2(-12.47393))));
    vec3 x = clamp((v + 12.47393) / (4.026069 + 12.47393), 0.0, 1.0);
    vec3 s = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x) + 0.1191) * x - 0.00232;
    return clamp(outset * s, 0.0, 1.0);
}

vec3 view(vec3 linear) {
    vec3 c = clamp(mix(linear, vec3(0.0), isnan(linear)) * exp2(exposure), vec3(0.0), vec3(32768.0));
    if (view_transform == 1) return srgb_encode(hable(2.0 * c) / hable(vec3(11.2)));
    if (view_transform == 2) return srgb_encode(neutral(c));
    if (view_transform == 3) return agx(c);
    if (view_transform == 4) {
        float edge = float(textureSize(config_view, 0).x);
        vec3 at = clamp((log2(max(c, vec3(exp2(-14.0)))) + 14.0) / 24.0, 0.0, 1.0);
        return textureLod(config_view, (at * (edge - 1.0) + 0.5) / edge, 0.0).rgb;
    }
    return srgb_encode(c);
}

void main() {
    vec2 at = gl_FragCoord.xy / extent;
    vec4 a = textureLod(picture_a, at, 0.0);
    if (difference_scale > 0.0) {
        color = vec4(srgb_encode(abs(a.rgb - textureLod(picture_b, at, 0.0).rgb) * difference_scale), 1.0);
    } else if (opaque) {
        color = vec4(view(a.rgb), 1.0);
    } else {  // where nothing is behind the cloth the window shows a plain grey
        color = vec4(mix(vec3(0.16), view(a.rgb / max(a.a, 1e-6)), clamp(a.a, 0.0, 1.0)), 1.0);
    }
}
