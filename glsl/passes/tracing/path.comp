#version 430
// Progressive path tracing: some samples of every pixel of a part of the picture, added to sums.   [Kajiya 1986; own]
// Light is sampled at every vertex (a sun; the lamp; a direction of the sky, weighted by the balance heuristic against those that
// the surface draws   [Veach 1995]), and paths end by Russian roulette. Defines: SHEER, where cloth lets light through;
// PICTURES, where there are prints, openings, fabric masks or objects with pictures; CATCHER, where of the ground only the shadow
// is seen; WEAVE and its kin, where pixels may show threads (inputs/tracing/path_threads.glsl).
// What is drawn fills its interval evenly over the samples of a pixel, each draw by itself   [Burley 2020].
// Few samples a dispatch (glcloth/tracing/path.py): loops may end silently after 65,535 iterations.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "sight.glsl"
#include "inputs/tracing/path_fabric.glsl"
#include "core/equirect.glsl"
#include "trace/sun_disc.glsl"
#include "sky.glsl"
#ifdef SHEER
#include "trace/spread.glsl"
#endif
layout(std430) buffer Sums { vec4 sums[]; };  // SUM_TEXELS a pixel: light and, of blocks, its luminance squared; N, cover; albedo, a block's luminance so far
uniform sampler2D environment_map;  // behind all
uniform mat3 map_from_world;
uniform bool background;
uniform ivec2 size;
uniform int first_pixel;
uniform int pixel_count;
uniform int first_sample;
uniform int sample_count;
uniform int block;                  // samples, whose sums are more nearly independent of each other than samples are
uniform int most_vertices;          // surfaces on the way that scatter; what they send to the next ones is lost
uniform mat3 ray_from_pixel;
uniform mat3 origin_from_pixel;
uniform vec3 lens_x;                // half axes of the lens
uniform vec3 lens_y;
uniform float focus;                // along the view
uniform samplerBuffer sun_data;     // of each (direction, share of those up to it), (irradiance over its share, tangent of its radius)
uniform int drawn_suns;
uniform vec3 lamp;                  // where it is; no ray meets it
uniform vec3 lamp_x;                // half axes of its disc
uniform vec3 lamp_y;
uniform vec3 intensity;             // W/sr
uniform bool has_lamp;

const int SUM_TEXELS = 3;
const int STEPS = 24;               // surfaces on a path, those that let it go on straight among them
const int SURE = 3;                 // vertices before roulette begins
const float SURVIVAL = 0.95;        // at most
const float LEAST_REFLECTED = 0.02;  // of the draws at a sheet
const float DARK = 1e-7;            // of the light is not worth a ray

uvec3 state;                        // pixel, sample, draws so far
#ifdef WEAVE
uniform bool in_parallel;
vec3 eye_ray;                       // of the sample, 1 along the view
#endif

vec3 rnd() {
    state.z += 1u;
    return stratified(state.y, hash3(uvec3(state.x, 0u, state.z)));
}

struct Path {
    vec3 o, d;
    float from;      // hits count beyond
    vec3 T;          // what light at its end counts for
    float pdf;       // with which d was drawn, where it might have been drawn from the sky; 0: it could not
    bool seen;       // straight from the eye
    bool early;      // nothing has scattered it yet
    int vertices;
    bool more;
};

#ifdef SHEER
vec3 corner_of(int triangle, int k) {
    return texelFetch(hit_vertices, 3 * texelFetch(hit_corners, 3 * triangle + k).x).xyz;
}

uniform bool spread;  // what yarns let through is drawn from its lobes, instead of the narrow ones going straight on

// The share of light that goes straight on.
vec3 straight_through(Visit visit, vec3 d) {
#ifdef PICTURES
    vec2 uv = uv_at(int(visit.triangle), visit.weights);
    int cloth = cloth_of(int(visit.triangle));
    cloth += fabric_at(cloth, uv);
    Sheet sheet = sheet_of(cloth, visit, d);
#else
    Sheet sheet = sheet_at(visit, d);
#endif
    vec3 T = T_s_of(sheet);
    if (spread && sheet.number >= 0) {
        vec4 p = texelFetch(sheet_data, 2 * sheet.number);
        T = vec3(p.y * T_open(sheet.omega, p.x));
    }
#ifdef PICTURES
    T = mix(vec3(1.0), T, closed_at(cloth, uv));
#endif
    return T;
}
#endif

struct Sample {
    vec3 L;
    vec3 N;
    vec3 albedo;
    float cover;
};

// The light that is left along a ray of what comes from that far away.
#ifdef SHEER
vec3 light_left(vec3 o, vec3 d, float reach) {
    Visit visit = shadow_visit(reach);
    Ray ray = make_ray(o, d, 0.0, reach);
    traverse(ray, visit);
    vec3 T = vec3(visit.t > 0.0 ? 1.0 : 0.0);
    int n = visit.t > 0.0 ? visit.layers : 0;
    vec4 latest_t = vec4(-1.0), earlier_t = vec4(-1.0);
    while (n-- > 0 && worth(T)) {
        int t = int(visit.latest.x);
        vec4 hit = meet_triangle(ray, corner_of(t, 0), corner_of(t, 1), corner_of(t, 2));
        visit.triangle = uint(t);
        visit.weights = hit.yz;
        // Two hits within a hair, as on an edge that two triangles share, are one layer.
        float hair = 1e-5 * (1.0 + hit.x);
        bool known = any(lessThan(abs(latest_t - hit.x), vec4(hair))) || any(lessThan(abs(earlier_t - hit.x), vec4(hair)));
        vec3 straight = straight_through(visit, d);
        T *= known ? vec3(1.0) : straight;
        earlier_t = vec4(latest_t.w, earlier_t.xyz);
        latest_t = vec4(hit.x, latest_t.xyz);
        visit.latest = uvec4(visit.latest.yzw, visit.earlier.x);
        visit.earlier.xyz = visit.earlier.yzw;
    }
    return worth(T) ? T : vec3(0.0);
}
#else
vec3 light_left(vec3 o, vec3 d, float reach) {
    Visit visit = Visit(reach, ANY_HIT, vec2(0.0));
    traverse(make_ray(o, d, 0.0, reach), visit);
    return vec3(visit.t > 0.0 ? 1.0 : 0.0);
}
#endif

// What a point sends toward where the ray comes from, of light from a direction (its frame), and the density with which it
// draws that direction: `chances` of reflection and of what comes evenly through. `lobes`: of light from behind not the even
// share alone, but all that yarns let through.
vec3 scattered(Point point, Fabric fabric, vec3 omega_i, vec3 omega_o, vec2 chances, bool lobes, out float pdf) {
    if (point.cloth < 0) {
        pdf = max(omega_i.z, 0.0) / PI;
        return point.reflectance * pdf;
    }
    vec3 f = f_and_pdf(fabric, omega_i, omega_o, pdf);
    pdf *= chances.x;
#ifdef SHEER
    if (omega_i.z < 0.0) {
        vec4 p = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 1);
        vec3 tau = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 2).xyz;
        vec3 i = vec3(omega_i.xy, -omega_i.z), o = vec3(omega_o.xy, -omega_o.z);
        if (lobes) {
            vec4 q = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 3);
            vec2 rough = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 5).xy;
            f = absorption(i, o, tau) * f_through(i, o, p.z, p.x, rough.x, q.x, q.y, p.w, rough.y);
        } else {
            f = f_lambert(i, o, p.z, tau, p.x, p.w);
        }
#ifdef WEAVE
        f *= covering;
#endif
        pdf = chances.y * -omega_i.z / PI;
        // Drawn directions are then those of the lobes, and no light is sampled there but the lamp, which they never meet.
        if (spread) {
            f = lobes ? f : vec3(0.0);
            pdf = 0.0;
        }
    }
#endif
    return f;
}

const int SUN = 0, SKY = 1, LAMP = 2;

// A direction to a sun, and its irradiance over the chance to be drawn.
vec3 drawn_sun(float choice, vec2 place, out vec3 light) {
    int s = 0;
    while (s + 1 < drawn_suns && choice >= texelFetch(sun_data, 2 * s).w) ++s;
    vec4 sun = texelFetch(sun_data, 2 * s + 1);
    float turn = 2.0 * PI * place.y;
    light = sun.rgb;
    return disc_direction(texelFetch(sun_data, 2 * s).xyz, sun.w, sqrt(place.x) * vec2(cos(turn), sin(turn)));
}

// The light of a sun, of a direction of the sky or of the lamp that reaches a point and goes on along the path.
vec3 lit(Point point, Fabric fabric, vec3 omega_o, vec2 chances, int kind, Path path) {
    vec3 choice = rnd(), place = rnd();
    vec3 d, light;
    float pdf_sky = 0.0, pdf, reach = 3e38;
    if (kind == LAMP) {
        float turn = 2.0 * PI * place.y;
        vec3 end = lamp + sqrt(place.x) * (cos(turn) * lamp_x + sin(turn) * lamp_y);
        vec3 way = end - (dot(end - point.origin, point.N_g) < 0.0 ? point.behind : point.origin);
        reach = max(length(way), 1e-6);
        d = way / reach;
        light = intensity / (reach * reach);
    } else if (kind == SUN) {
        d = drawn_sun(choice.x, place.xy, light);
    } else {
        d = sky_direction(point.origin, choice.xy, place.xy);
        light = sky_radiance(point.origin, d, pdf_sky);
    }
    vec3 omega_i = d * point.frame;
    // A lamp without size is met by no ray that goes straight on: what narrow lobes bring of it to the eye is added here.
    // After that they belong to the straight rays.
    bool lobes = kind == LAMP && path.early;
    vec3 f = scattered(point, fabric, omega_i, omega_o, chances, lobes, pdf);
    vec3 L = path.T * f * light * (kind == SKY ? pdf_sky > 0.0 ? 1.0 / (pdf_sky + pdf) : 0.0 : 1.0);
    bool worth_it = most(abs(L)) > DARK;
    // A ray that is not worth it is sent nowhere.
    vec3 left = vec3(0.0);
    if (worth_it) left = light_left(omega_i.z < 0.0 ? point.behind : point.origin, d, reach);
    return L * left;
}

// What a path brings that leaves the scene.
vec3 from_sky(Path path) {
    vec3 behind = background ? textureLod(environment_map, uv_from_direction(normalize(map_from_world * path.d)), 0.0).rgb
        : vec3(0.0);
    float pdf_sky;
    vec3 light = sky_radiance(path.o, path.d, pdf_sky);
    light *= path.pdf > 0.0 ? path.pdf / (path.pdf + pdf_sky) : 1.0;
    return path.T * (path.seen ? behind : light);
}

// The path goes on from a point in a drawn direction.
void scatter(inout Path path, Point point, Fabric fabric, vec3 omega_o, vec2 chances) {
    vec3 u = rnd();
    bool through = false;
    vec3 omega_i;
    path.seen = path.early = false;
#ifdef SHEER
    through = u.z * (chances.x + chances.y) >= chances.x;
    if (!through) u.z = u.z * (chances.x + chances.y) / max(chances.x, 1e-20);
#endif
    if (through || point.cloth < 0) omega_i = cosine_direction(u.xy);
    else omega_i = drawn_direction(fabric, omega_o, min(u.z, 0.9999999), u.xy);
    omega_i.z *= through ? -1.0 : 1.0;
    float pdf;
    vec3 f = scattered(point, fabric, omega_i, omega_o, chances, false, pdf);
    // A lobe may reach below the horizon, where only what goes through is drawn.
    path.T *= pdf > 0.0 && through == omega_i.z < 0.0 ? f / pdf : vec3(0.0);
    path.pdf = pdf;
    path.o = through ? point.behind : point.origin;
    path.d = point.frame * omega_i;
    path.from = 0.0;
    path.vertices += 1;
}

void roulette(inout Path path) {
    float left = most(path.T);
    float q = path.vertices > SURE ? min(left, SURVIVAL) : 1.0;
    path.more = path.more && left > 0.0 && rnd().x < q;
    path.T /= max(q, 1e-20);
}

#ifdef SHEER
// What a sheet does with light besides reflecting it: straight on, evenly through, mirrored.
struct Shares {
    vec3 straight;
    vec3 evenly;
    float mirrored;
    vec4 chances;  // to be reflected, to go evenly through, straight on, to be mirrored
};

Shares shares_of(Point point, vec3 omega_o) {
    int first = CLOTH_TEXELS * max(point.cloth, 0);
    vec4 p = texelFetch(cloth_data, first + 1), q = texelFetch(cloth_data, first + 3);
    vec3 tau = texelFetch(cloth_data, first + 2).xyz, albedo = texelFetch(cloth_data, first + 4).rgb;
    if (point.cloth < 0 || q.w == 0.0) return Shares(vec3(0.0), vec3(0.0), 0.0, vec4(1.0, 0.0, 0.0, 0.0));
    vec3 straight = T_straight(omega_o, p.y, p.z, tau, p.x, p.w), evenly = T_lambert(omega_o, p.z, tau, p.x, p.w);
    if (spread) {
        vec4 parts = straight_parts(omega_o, p.y, p.z, tau, p.x);
        straight = vec3(parts.a);
        evenly = parts.rgb;
    }
    float mirrored = R_limited(R_sheet(omega_o, p.z, p.x, q.x, q.y), straight + evenly, albedo);
#ifdef WEAVE
    if (at_threads) {
        float hole = hole_share(reads_as);
        covering = (1.0 - hole) / max(1.0 - hole_mean, 1e-6);
        straight = spread ? vec3(p.y * open_at(T_open(omega_o, p.x), hole, hole_mean))
            : T_sheet_at(omega_o, p.y, p.z * (1.0 - 0.5 * p.w), tau, p.x, hole, hole_mean);
        evenly *= covering;
        mirrored *= covering;
        albedo *= covering;
    }
#endif
    vec4 chances = vec4(max(most(albedo), LEAST_REFLECTED), most(evenly), most(straight), mirrored);
    return Shares(straight, evenly, mirrored, chances / dot(chances, vec4(1.0)));
}

void go_straight(inout Path path, vec3 T, float t) {
    path.T *= T;
    path.from = behind_layer(t);
}

void go_mirrored(inout Path path, Point point, float T) {
    path.T *= T;
    path.d = mirrored_direction(path.d, point.frame[2], point.N_g);
    path.o = point.origin;
    path.from = 0.0;
    path.pdf = 0.0;
    path.seen = false;
    path.vertices += 1;
}
#endif

#ifdef SHEER
// The path goes on through the yarns in a direction of their lobes.
void go_spread(inout Path path, Point point, vec3 omega_o, vec3 T) {
    vec4 p = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 1), q = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 3);
    vec2 rough = texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 5).xy;
    vec3 u = rnd();
    vec3 d = point.frame * yarn_direction(omega_o, u.xy, u.z, rough.x, q.x, q.y, p.w, rough.y);
    path.T *= dot(d, point.N_g) < 0.0 ? T : vec3(0.0);
    path.d = d;
    path.o = point.behind;
    path.from = 0.0;
    path.pdf = 0.0;
    path.seen = path.early = false;
    path.vertices += 1;
}
#endif

#ifdef CATCHER
uniform vec2 catcher_middle;    // x and z
uniform vec2 catcher_fade;      // from this distance on less of it is seen, to that one
uniform float open_luminance;   // of the irradiance of the ground where nothing hides light

// The share of the light that is hidden from a point of the ground, by one sample of the suns and one of the sky; of many the mean.
float hidden_at(Point point) {
    float hidden = 0.0;
    int kind = drawn_suns > 0 ? SUN : SKY;
    do {
        vec3 choice = rnd(), place = rnd(), d, light;
        float pdf = 1.0;
        if (kind == SUN) {
            d = drawn_sun(choice.x, place.xy, light);
        } else {
            d = sky_direction(point.origin, choice.xy, place.xy);
            light = sky_radiance(point.origin, d, pdf);
        }
        float seen = luminance(light) * max(d.y, 0.0) * (pdf > 0.0 ? 1.0 / pdf : 0.0);
        if (seen > 0.0) hidden += seen - luminance(light * light_left(point.origin, d, 3e38)) * d.y / pdf;
    } while (++kind <= SKY);
    float shown = 1.0 - smoothstep(catcher_fade.x, catcher_fade.y, length(point.origin.xz - catcher_middle));
    return shown * hidden / open_luminance;
}
#endif

// One surface on the way.
void meet(inout Path path, Visit visit, inout Sample one) {
    Point point;
    if (visit.triangle == GROUND) point = ground_point(path.o, path.d, visit.t);
    else point = point_at(int(visit.triangle), visit.weights, path.d);
    vec3 omega_o = -path.d * point.frame;
#ifdef CATCHER
    if (visit.triangle == GROUND && path.seen) {
        path.T *= 1.0 - (path.d.y < 0.0 ? hidden_at(point) : 0.0);
        path.from = behind_layer(visit.t);
        return;
    }
#endif
#ifdef PICTURES
    vec2 uv = vec2(0.0);
    if (visit.triangle != GROUND) {
        uv = uv_at(int(visit.triangle), visit.weights);
        if (point.cloth >= 0) point.cloth += fabric_at(point.cloth, uv);
    }
#endif
    Fabric fabric = fetch_fabric(max(point.cloth, 0));
#ifdef WEAVE
    leave_threads();
#endif
#ifdef PICTURES
    if (visit.triangle != GROUND) {
        if (point.cloth < 0) {
            point.reflectance *= picture_at(texelFetch(solid_data, int(visit.triangle) - cloth_triangles).w, uv);
        } else {
#ifdef SHEER
            if (rnd().x >= closed_at(point.cloth, uv)) {
                go_straight(path, vec3(1.0), visit.t);
                return;
            }
#endif
            fabric.tint = printed_at(point.cloth, uv);
        }
    }
#endif
#ifdef WEAVE
    if (path.seen && point.cloth >= 0) {
        if (!claims(point.cloth)) {
            path.more = false;
            return;
        }
        come_to_threads(point.cloth, int(visit.triangle), visit.weights, fabric.tint, eye_ray,
            in_parallel ? 1.0 : visit.t / length(eye_ray));
    }
#endif
    if (one.cover == 0.0) {
        one.N = point.frame[2];
        one.albedo = point.cloth < 0 ? point.reflectance
            : fabric.tint * texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 4).rgb;
#ifdef WEAVE
        if (at_threads) one.albedo = min(seen_evenly() * texelFetch(cloth_data, CLOTH_TEXELS * point.cloth + 4).rgb, 1.0);
#endif
        one.cover = 1.0;
    }
    vec2 chances = vec2(1.0, 0.0);
#ifdef SHEER
    Shares shares = shares_of(point, omega_o);
    chances = shares.chances.xy;
    bool last = path.vertices >= most_vertices;
    float pick = rnd().x - chances.x - chances.y;
    // What nothing may scatter again still goes through sheets.
    if (last) {
        go_straight(path, shares.straight, visit.t);
        path.more = most(path.T) > DARK;
        return;
    }
#else
    if (path.vertices >= most_vertices) {
        path.more = false;
        return;
    }
#endif
    int kind = drawn_suns > 0 ? SUN : SKY;
    int kinds = has_lamp ? LAMP : SKY;
    do {
        one.L += lit(point, fabric, omega_o, chances, kind, path);
    } while (++kind <= kinds);
#ifdef SHEER
    if (pick >= shares.chances.z) go_mirrored(path, point, shares.mirrored / max(shares.chances.w, 1e-20));
    else if (pick >= 0.0) go_straight(path, shares.straight / shares.chances.z, visit.t);
    else if (spread && pick + chances.y >= 0.0) go_spread(path, point, omega_o, shares.evenly / chances.y);
    else
#endif
    {
#ifdef SHEER
        chances.y *= spread ? 0.0 : 1.0;
#endif
        scatter(path, point, fabric, omega_o, chances);
    }
    roulette(path);
}

Sample sample_of(ivec2 pixel) {
    vec3 in_pixel = rnd(), on_lens = rnd();
    vec3 at = vec3(vec2(pixel) + in_pixel.xy, 1.0);
    vec3 o = origin_from_pixel * at, d = ray_from_pixel * at;
    float r = sqrt(on_lens.x), turn = 2.0 * PI * on_lens.y;
    vec3 step_off = r * (cos(turn) * lens_x + sin(turn) * lens_y);
    d -= step_off / focus;
#ifdef WEAVE
    eye_ray = d;
    claimed = -1;
    reads_as = ivec2(state.y, state.y >> 2u) & 3;
#endif
    d = normalize(d);
    Path path = Path(o + step_off, d, 0.0, vec3(1.0), 0.0, true, true, 0, true);
    Sample one = Sample(vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    int steps = 0;
    do {
        Visit visit = closest_visit();
        traverse(make_ray(path.o, path.d, path.from, 3e38), visit);
        if (visit.triangle == NO_TRIANGLE) {
            one.L += from_sky(path);
            if (path.seen && steps > 0) one.cover = 1.0 - dot(path.T, vec3(1.0 / 3.0));
            path.more = false;
        } else {
            meet(path, visit, one);
        }
#ifdef WEAVE
        // What meets no woven cloth from the eye belongs to the first dispatch.
        if (!path.seen && claimed < 0 && dispatch > 0) path.more = false;
#endif
    } while (path.more && ++steps < STEPS);
#ifdef WEAVE
    if (max(claimed, 0) != dispatch) one = Sample(vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
#endif
    return one;
}

void main() {
    int i = item();
    if (i >= pixel_count) return;
    i += first_pixel;
    ivec2 pixel = ivec2(i % size.x, i / size.x);
    vec4 light = vec4(0.0), look = vec4(0.0);
    vec4 albedo = vec4(vec3(0.0), sums[SUM_TEXELS * i + 2].w);
    int n = first_sample;
    do {
        state = uvec3(uint(i), uint(n), 0u);
        Sample one = sample_of(pixel);
        bool good = !any(isnan(one.L)) && !any(isinf(one.L));
        one.L = good ? one.L : vec3(0.0);
        albedo.w += luminance(one.L);
        light += vec4(one.L, 0.0);
        if ((n + 1) % block == 0) {
            light.w += albedo.w * albedo.w;
            albedo.w = 0.0;
        }
        look += vec4(one.N, one.cover);
        albedo.rgb += one.albedo;
    } while (++n < first_sample + sample_count);
    sums[SUM_TEXELS * i] += light;
    sums[SUM_TEXELS * i + 1] += look;
    sums[SUM_TEXELS * i + 2] = vec4(sums[SUM_TEXELS * i + 2].rgb + albedo.rgb, albedo.w);
}
