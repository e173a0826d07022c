// Shaders of still pictures, GLSL 4.50, and the pieces shared with live pictures
// (render/eye_shaders.h): `common`, `shading`, `ground`, `tones`. Values shared with C++ are in
// `still_constants`, generated from the C++ values, and in ViewBlock.
#pragma once
#include <cmath>
#include <string>

#include "render/lights.h"

namespace knead {

constexpr int samples_across = 2;                        // samples per pixel along each axis
constexpr int key_map_side = 1024, dome_map_side = 512;  // texels of a shadow map

inline std::string constant(const char* name, int value)
{
    return "const int " + std::string(name) + " = " + std::to_string(value) + ";\n";
}
inline std::string still_constants()
{
    return "#version 450 core\n" + constant("key_lamps", key_lamps) +
           constant("dome_lamps", dome_lamps) + constant("lamps", lamps) +
           constant("samples_across", samples_across) + constant("key_map_side", key_map_side) +
           constant("dome_map_side", dome_map_side);
}

// Uniform block (std140); the fields are explained in `common`.
struct ViewBlock {
    float eye[4], right[4], up[4], forward[4], ball[4], scale[4], sky[4], shift[4];
};
inline void put(float (&to)[4], Vec3<float> v, float w)
{
    to[0] = v.x, to[1] = v.y, to[2] = v.z, to[3] = w;
}
// Spacing of the floor's lines for an eye at this distance from its target [m].
inline float line_spacing(float distance)
{
    return std::pow(10.0f, std::round(std::log10(distance / 8)));
}

constexpr const char* common = R"(
struct Lamp {
    vec4 row[3];
    vec4 towards;
};
layout(std140, binding = 0) uniform Lamps { Lamp lamp[lamps]; };
layout(std140, binding = 1) uniform View {
    vec4 eye;       // position [m]; w: near plane [m]
    vec4 right;     // unit vector times the tangent of half the field of view; w: reciprocal of
                    // that tangent
    vec4 up;        // likewise
    vec4 forward;   // unit vector; w: height of the floor [m]
    vec4 ball;      // bounding ball of the shadow casters: centre, radius [m]
    vec4 scale;     // grid spacing of the floor [m], radius at which it has faded [m], angle of a
                    // pixel [rad]
    vec4 sky;       // direction towards the brighter side of the sky
    vec4 shift;     // offset of the frustum's centre from the view axis, in half fields of view:
                    // right, up
};
vec3 shadow_coord(Lamp l, vec3 p) {
    return vec3(dot(l.row[0], vec4(p, 1)), dot(l.row[1], vec4(p, 1)), dot(l.row[2], vec4(p, 1)));
}
// Reversed depth: near / distance along the view axis; 1 at the near plane, 0 at infinity.
vec4 projected(vec3 place) {
    vec3 d = place - eye.xyz;
    float view_depth = dot(d, forward.xyz);
    return vec4(dot(d, right.xyz) * right.w * right.w - shift.x * view_depth,
                dot(d, up.xyz) * up.w * up.w - shift.y * view_depth, eye.w, view_depth);
}
// View ray through a point of the picture in [-1, 1]^2, with component 1 along the view axis.
vec3 ray_through(vec2 at) {
    return forward.xyz + (at.x + shift.x) * right.xyz + (at.y + shift.y) * up.xyz;
}
)";

// Depth of shadow casters from one lamp.
constexpr const char* shadow_vertex = R"(
layout(location = 0) in vec3 place;
layout(location = 0) uniform int number;
void main() {
    vec3 m = shadow_coord(lamp[number], place);
    gl_Position = vec4(2 * m.xy - 1, m.z, 1);
}
)";
constexpr const char* shadow_fragment = R"(
void main() {}
)";

// Normal, colour and depth from the camera.
constexpr const char* scene_vertex = R"(
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
out vec3 vertex_normal;
out vec4 vertex_colour;
void main() {
    gl_Position = projected(place);
    vertex_normal = normal;
    vertex_colour = colour;
}
)";
constexpr const char* scene_fragment = R"(
in vec3 vertex_normal;
in vec4 vertex_colour;
layout(location = 0) out vec4 seen_normal;
layout(location = 1) out vec4 seen_colour;
void main() {
    float size = length(vertex_normal);
    vec3 n = size > 0 ? vertex_normal / size : vec3(0, 1, 0);
    seen_normal = vec4(gl_FrontFacing ? n : -n, 0);
    seen_colour = vertex_colour;
}
)";

constexpr const char* screen_vertex = R"(
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1);
}
)";

// Light sources, and reflection by clay, skin and floor.
constexpr const char* shading = R"(
const vec3 key_colour = vec3(1.48, 1.38, 1.24);
const vec3 floor_colour = vec3(0.30, 0.30, 0.31);

// Radiance of the sky: brighter at the zenith and on the side opposite the key light, so that
// shapes remain visible in shade.
vec3 sky_from(vec3 l) {
    return mix(vec3(0.40, 0.42, 0.46), vec3(0.58, 0.64, 0.74), l.y) *
           (0.72 + 0.45 * dot(l, sky.xyz));
}
vec3 backdrop(float height) {
    return mix(vec3(0.50, 0.51, 0.52), vec3(0.27, 0.30, 0.35), smoothstep(0.0, 0.7, height));
}
// Specular highlight of a lamp: normalised Blinn-Phong with a Fresnel factor, broad on clay,
// broader on skin.
float specular(vec3 n, vec3 l, vec3 view, float skin) {
    float shine = mix(22, 9, skin), gloss = mix(0.050, 0.030, skin);
    vec3 h = normalize(l + view);
    float fresnel = 1 + 4 * pow(1 - max(dot(h, view), 0), 5);
    return fresnel * gloss * (shine + 8) / 8 * pow(max(dot(n, h), 0), shine);
}
// Light reflected by the floor; less for points near the floor, where it is in shade.
vec3 floor_bounce(vec3 p, vec3 n) {
    float height = max(p.y - forward.w, 0);
    float clear = mix(0.10, 1.0, height / (height + 0.35 * ball.w));
    return 0.75 * clear * (0.5 - 0.5 * n.y) * floor_colour;
}
// Translucency of skin at grazing angles; `open`: visible fraction of the sky.
vec3 translucency(vec3 n, vec3 view, float skin, float open) {
    return skin * 0.22 * pow(1 - max(dot(n, view), 0), 3) * (0.3 + open) * vec3(1.0, 0.72, 0.60);
}
)";

constexpr const char* ground = R"(
// Coverage of the lines of a grid by a pixel's footprint, antialiased: a line is at least a pixel
// wide, and lines denser than pixels fade out. All in metres.
float line(float at, float spacing, float width, float footprint) {
    float d = abs(fract(at / spacing + 0.5) - 0.5) * spacing;
    float soft = max(footprint, 0.5 * width);
    float coverage = 1 - smoothstep(width - soft, width + soft, d);
    return coverage * min(1.0, width / footprint) *
           (1 - smoothstep(0.1, 0.35, footprint / spacing));
}

vec3 floor_at(vec3 p, vec3 ray, float distance) {
    float footprint = distance * scale.z / max(-normalize(ray).y, 0.02);
    float w = 0.006 * scale.x;
    float lines = max(line(p.x, scale.x, w, footprint), line(p.z, scale.x, w, footprint));
    float strong = max(line(p.x, 5 * scale.x, 2 * w, footprint),
                       line(p.z, 5 * scale.x, 2 * w, footprint));
    return floor_colour * (1 - 0.20 * lines) * (1 - 0.28 * strong);
}
)";

constexpr const char* tones = R"(
// Tone curve: linear up to a knee, then a shoulder that approaches 1.
vec3 tone_map(vec3 c) {
    const float knee = 0.6;
    vec3 over = max(c - knee, 0);
    return clamp(min(c, knee) + (1 - knee) * over / (over + (1 - knee)), 0, 1);
}
// Linear to sRGB, and the inverse.
vec3 to_srgb(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(c, vec3(1 / 2.4)) - 0.055, step(0.0031308, c));
}
vec3 from_srgb(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}
)";

// Lighting of geometry, floor or backdrop. Each sample of a pixel uses a quarter of the lamps; the
// mean over the pixel has all of them.
constexpr const char* light_fragment = R"(
layout(binding = 0) uniform sampler2D normals;
layout(binding = 1) uniform sampler2D colours;
layout(binding = 2) uniform sampler2D depths;
layout(binding = 3) uniform sampler2DArrayShadow key_maps;
layout(binding = 4) uniform sampler2DArrayShadow dome_maps;
layout(location = 0) uniform vec2 size;  // of the picture [samples]
out vec4 radiance;

// Interleaved gradient noise [Jimenez 2014] in [0, 1): neighbouring pixels differ, so that their
// mean is smooth.
float grain(vec2 at) { return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715)))); }

// Visibility of lamp l from p: the mean of two shadow lookups, at an offset within a square of half
// width `blur` (fraction of the map) and at the opposite offset. The offset differs between samples
// and lamps: sequence R2 [Roberts 2018].
float lamp_visibility(sampler2DArrayShadow maps, int layer, Lamp l, vec3 p, vec2 turn, float blur) {
    vec3 m = shadow_coord(l, p);
    vec2 aside = blur * (2 * fract(turn + layer * vec2(0.7548777, 0.5698403)) - 1);
    float depth = clamp(m.z, 0, 1) - 3e-4;
    return 0.5 * (texture(maps, vec4(m.xy + aside, layer, depth)) +
                  texture(maps, vec4(m.xy - aside, layer, depth)));
}

vec3 shade(vec3 p, vec3 n, vec3 view, vec3 colour, float skin) {
    int quarter = int(gl_FragCoord.x) % 2 + 2 * (int(gl_FragCoord.y) % 2);
    float texel = 2 * ball.w / key_map_side;
    vec2 turn = vec2(grain(gl_FragCoord.xy), grain(gl_FragCoord.yx + 37));
    vec3 key = vec3(0), glint = vec3(0), dome = vec3(0);
    for (int i = quarter; i < key_lamps; i += 4) {
        vec3 l = lamp[i].towards.xyz;
        float cosine = dot(n, l);
        if (cosine <= 0) continue;
        float share = cosine * lamp_visibility(key_maps, i, lamp[i], p + (2.5 * texel) * n, turn,
                                               1.8 / key_map_side);
        key += share;
        glint += share * specular(n, l, view, skin);
    }
    texel = 2 * ball.w / dome_map_side;
    float open = 0;
    for (int i = quarter; i < dome_lamps; i += 4) {
        Lamp l = lamp[key_lamps + i];
        float cosine = dot(n, l.towards.xyz);
        if (cosine <= 0) continue;
        float share = cosine * lamp_visibility(dome_maps, i, l, p + (2.0 * texel) * n, turn,
                                               2.0 / dome_map_side);
        dome += share * sky_from(l.towards.xyz);
        open += share;
    }
    // Radiance is colour / pi times irradiance; a lamp of the dome represents 2 pi / dome_lamps sr.
    float key_share = 4.0 / key_lamps, dome_share = 4.0 * 2.0 / dome_lamps;
    open *= dome_share;
    vec3 light = key * key_share * key_colour + dome * dome_share + floor_bounce(p, n);
    return colour * light + glint * key_share * key_colour + translucency(n, view, skin, open);
}

void main() {
    vec3 ray = ray_through(2 * gl_FragCoord.xy / size - 1);
    ivec2 cell = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, cell, 0).r;
    float distance = depth > 0 ? eye.w / depth : 1e30;
    float ground = ray.y < 0 && eye.y > forward.w ? (forward.w - eye.y) / ray.y : 1e30;
    float rise = normalize(ray).y;
    radiance = vec4(backdrop(max(rise, 0)), 1);
    if (min(distance, ground) > 1e29) return;
    if (distance < ground) {
        vec4 colour = texelFetch(colours, cell, 0);
        vec3 n = texelFetch(normals, cell, 0).xyz;
        radiance.rgb = shade(eye.xyz + distance * ray, n, -normalize(ray), colour.rgb, colour.a);
    } else {
        vec3 p = eye.xyz + ground * ray;
        vec3 colour = floor_at(p, ray, ground * length(ray));
        vec3 c = shade(p, vec3(0, 1, 0), vec3(0, 1, 0), colour, 0);
        float fade = smoothstep(0.25, 1.0, length(p.xz - ball.xz) / scale.y);
        radiance.rgb = mix(c, radiance.rgb, fade);
    }
}
)";

// Mean of the samples, then tone mapping, then sRGB.
constexpr const char* tone_fragment = R"(
layout(binding = 0) uniform sampler2D radiances;
out vec4 tone;
void main() {
    ivec2 first = samples_across * ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0);
    for (int y = 0; y < samples_across; ++y)
        for (int x = 0; x < samples_across; ++x)
            sum += texelFetch(radiances, first + ivec2(x, y), 0).rgb;
    tone = vec4(to_srgb(tone_map(sum / (samples_across * samples_across))), 1);
}
)";

}  // namespace knead
