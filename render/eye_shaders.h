// Shaders of live pictures, GLSL 4.50. Lighting, floor and tone mapping as in still pictures
// (render/shaders.h), with fewer lamps: a key light, and the mean of the sky.
#pragma once
#include <string>

#include "render/shaders.h"

namespace knead {

constexpr int live_lamps = 2;                     // the key light; one at the zenith, which
                                                  // represents the whole sky
constexpr int key_side = 1024, zenith_side = 48;  // texels of their shadow maps

// GLSL array of points on a unit disk along a Fibonacci spiral.
inline std::string spiral(const std::string& name, int count)
{
    std::string text = "const vec2 " + name + "[" + std::to_string(count) + "] = vec2[](";
    for (int i = 0; i < count; ++i) {
        const float far = std::sqrt((float(i) + 0.5f) / float(count));
        const float turn = golden_angle * float(i);
        text += (i ? ", vec2(" : "vec2(") + std::to_string(far * std::cos(turn)) + ", " +
                std::to_string(far * std::sin(turn)) + ")";
    }
    return text + ");\n";
}

inline std::string live_constants(int samples)
{
    return "#version 450 core\n" + constant("lamps", live_lamps) + constant("key_side", key_side) +
           constant("zenith_side", zenith_side) + constant("samples", samples) +
           spiral("key_taps", samples < 2 ? 4 : 2 * samples);  // lookups, four texels each
}

// Lighting of a visible point. Shadow lookups have the same pattern for all pixels and both eyes:
// noise would flicker in motion.
constexpr const char* live_shading = R"(
layout(binding = 0) uniform sampler2DArrayShadow key_map;
layout(binding = 1) uniform sampler2DArrayShadow zenith_map;

float key_visibility(vec3 p, vec3 n) {
    const float spread = 3;  // texels
    vec3 m = shadow_coord(lamp[0], p + (spread + 1) * 2 * ball.w / key_side * n);
    if (any(greaterThan(abs(m.xy - 0.5), vec2(0.5)))) return 1;
    float depth = clamp(m.z, 0, 1) - 4e-4, open = 0;
    for (int i = 0; i < key_taps.length(); ++i)
        open += texture(key_map, vec4(m.xy + spread / key_side * key_taps[i], 0, depth));
    return open / key_taps.length();
}
// Fraction of a square around p that is not occluded from above, by percentage-closer filtering: 4
// x 4 texels are compared with the depth of p and weighted by a 3 x 3 tent, in four lookups of 2 x
// 2. Comparison must precede filtering: the mean depth of clay, a hand above it and the floor far
// below it is not the depth of an occluder. The offset along the normal is half the width r of the
// square, so that no slope shadows itself: on a plane inclined by the angle a, points within r
// occlude p only if the offset is below r sin(a).
float sky_visibility(vec3 p, vec3 n) {
    vec3 m = shadow_coord(lamp[1], p + 2 * 2 * ball.w / zenith_side * n);
    if (any(greaterThan(abs(m.xy - 0.5), vec2(0.5)))) return 1;
    vec2 at = m.xy * zenith_side, corner = floor(at + 0.5), s = at + 0.5 - corner;
    vec2 less = 3 - 2 * s, more = 1 + 2 * s;
    vec2 low = (corner + (2 - s) / less - 1.5) / zenith_side;
    vec2 high = (corner + s / more + 0.5) / zenith_side;
    float depth = clamp(m.z, 0, 1);
    return (less.x * less.y * texture(zenith_map, vec4(low, 0, depth)) +
            more.x * less.y * texture(zenith_map, vec4(high.x, low.y, 0, depth)) +
            less.x * more.y * texture(zenith_map, vec4(low.x, high.y, 0, depth)) +
            more.x * more.y * texture(zenith_map, vec4(high, 0, depth))) / 16;
}

vec3 shade(vec3 p, vec3 n, vec3 view, vec3 colour, float skin) {
    vec3 l = lamp[0].towards.xyz;
    float cosine = dot(n, l);
    float key = cosine > 0 ? cosine * key_visibility(p, n) : 0;
    // A surface without occluders sees the fraction (1 + n.y) / 2 of the sky, centred between its
    // normal and the zenith; occluders above reduce it.
    float open = 0.5 + 0.5 * n.y;
    // A surface that faces down is hidden from the zenith by its own body, which that fraction
    // already includes.
    float faces = smoothstep(-0.5, 0.0, n.y);
    if (faces > 0) open *= mix(1.0, mix(0.4, 1.0, sky_visibility(p, n)), faces);
    vec3 middle = n + vec3(0, 1.001, 0);
    vec3 light = key * key_colour + open * sky_from(normalize(middle)) + floor_bounce(p, n);
    float glint = key > 0 ? key * specular(n, l, view, skin) : 0;
    return colour * light + glint * key_colour + translucency(n, view, skin, open);
}
)";

constexpr const char* live_vertex = R"(
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
layout(location = 3) in float advance;  // displacement along the normal since the previous surface
                                        // [m]
layout(location = 3) uniform float extrapolation;
out vec3 vertex_place;
out vec3 vertex_normal;
out vec4 vertex_colour;
void main() {
    vec3 now = place + extrapolation * advance * normal;
    gl_Position = projected(now);
    vertex_place = now;
    vertex_normal = normal;
    vertex_colour = colour;
}
)";
// Screen-door transparency: sample masks with a 4 x 4 dither pattern need no sorting.
constexpr const char* live_fragment = R"(
in vec3 vertex_place;
in vec3 vertex_normal;
in vec4 vertex_colour;
layout(location = 1) uniform float opacity;
layout(location = 2) uniform vec3 glow;  // rim light, linear RGB
out vec4 radiance;
const int order[16] = int[](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
void main() {
    if (opacity < 1) {
        int at = int(gl_FragCoord.x) % 4 + 4 * (int(gl_FragCoord.y) % 4);
        int count = int(opacity * samples + (order[at] + 0.5) / 16);
        if (count == 0) discard;
        gl_SampleMask[0] = (1 << count) - 1;
    } else {
        gl_SampleMask[0] = ~0;
    }
    float size = length(vertex_normal);
    vec3 n = size > 0 ? vertex_normal / size : vec3(0, 1, 0);
    if (!gl_FrontFacing) n = -n;
    vec3 view = normalize(eye.xyz - vertex_place);
    vec3 c = shade(vertex_place, n, view, vertex_colour.rgb, vertex_colour.a);
    float edge = pow(1 - max(dot(n, view), 0), 2);
    radiance = vec4(tone_map(c + mix(0.03, 0.8, edge) * glow), 1);
}
)";

// The floor as two triangles; it fades into the backdrop.
constexpr const char* live_floor_vertex = R"(
out vec3 vertex_place;
void main() {
    vec2 side = 2 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1;
    vec2 at = ball.xz + scale.y * side;
    vertex_place = vec3(at.x, forward.w, at.y);
    gl_Position = projected(vertex_place);
}
)";
constexpr const char* live_floor_fragment = R"(
in vec3 vertex_place;
out vec4 radiance;
layout(location = 1) uniform float opaque;  // 1: the floor fades into the backdrop; 0: it fades to
                                            // transparent
void main() {
    vec3 ray = vertex_place - eye.xyz;
    vec3 colour = floor_at(vertex_place, ray, length(ray));
    vec3 up = vec3(0, 1, 0);
    float fade = smoothstep(0.25, 1.0, length(vertex_place.xz - ball.xz) / scale.y);
    vec3 c = mix(shade(vertex_place, up, up, colour, 0), backdrop(0), opaque * fade);
    radiance = opaque > 0 ? vec4(tone_map(c), 1) : (1 - fade) * vec4(tone_map(c), 1);
}
)";
constexpr const char* live_backdrop_vertex = R"(
out vec2 at;
void main() {
    at = vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1);
    gl_Position = vec4(at, 0, 1);
}
)";
constexpr const char* live_backdrop_fragment = R"(
in vec2 at;
out vec4 radiance;
void main() { radiance = vec4(tone_map(backdrop(max(normalize(ray_through(at)).y, 0))), 1); }
)";

// Hidden area: drawn first, at depth 1 (nearest), so that all later fragments fail the depth test.
// Alpha 0 at that depth marks it.
constexpr const char* live_hidden_vertex = R"(
layout(location = 0) in vec2 tangents;
void main() {
    gl_Position = vec4(tangents.x * right.w - shift.x, tangents.y * up.w - shift.y, 1, 1);
}
)";
constexpr const char* live_hidden_fragment = R"(
out vec4 radiance;
void main() { radiance = vec4(0); }
)";

// Resolves the samples to the caller's pixels: mean colour and nearest depth. Composites splats
// over the samples behind them, in display (sRGB) space as splat files define it; not over marked
// samples.
constexpr const char* live_output_without_marks = R"(
bool is_marked(ivec2 at, int s) { return false; }
)";
constexpr const char* live_output_marks = R"(
layout(binding = 4) uniform sampler2DMS marks;
bool is_marked(ivec2 at, int s) { return texelFetch(marks, at, s).r > 0.5; }
)";
constexpr const char* live_output_fragment = R"(
layout(binding = 0) uniform sampler2DMS colours;
layout(binding = 1) uniform sampler2DMS depths;
layout(binding = 2) uniform sampler2D splat_colours;
layout(binding = 3) uniform sampler2D splat_depths;
layout(location = 1) uniform vec4 picture;  // lower left corner and size [pixels]
layout(location = 2) uniform bool linear;   // write linear values: GL encodes them
layout(location = 3) uniform bool splats;
layout(location = 4) uniform bool hidden;  // the hidden area is not empty
layout(location = 5) uniform vec2 shown;   // used part of the splat textures, from the first texel
                                           // on [texels]; 0: all
out vec4 tone;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy - picture.xy);
    vec4 sum = vec4(0);
    float found[samples], nearest = 0;
    int seen = 0;
    for (int s = 0; s < samples; ++s) {
        vec4 colour = texelFetch(colours, at, s);
        float depth = texelFetch(depths, at, s).r;
        if (hidden && depth == 1 && colour.a == 0) continue;
        sum += colour;
        nearest = max(nearest, depth);
        found[seen++] = is_marked(at, s) ? 1e30 : depth;
    }
    tone = vec4(0);
    gl_FragDepth = 0;
    if (seen == 0) return;
    sum /= seen;
    vec2 spot = (gl_FragCoord.xy - picture.xy) / picture.zw;
    spot.y = 1 - spot.y;
    if (shown.x > 0)
        spot = clamp(spot * shown, vec2(0.5), shown - 0.5) / vec2(textureSize(splat_colours, 0));
    float splat_depth = splats ? textureLod(splat_depths, spot, 0).r : 1e30, behind = 0;
    for (int s = 0; s < seen; ++s)
        if (splat_depth * found[s] < eye.w) behind += 1.0 / seen;
    // Colours are premultiplied by coverage.
    vec3 c = sum.a > 0 ? to_srgb(sum.rgb / sum.a) * sum.a : vec3(0);
    float coverage = sum.a;
    if (splats && behind > 0) {
        vec4 over = behind * textureLod(splat_colours, spot, 0);
        c = over.rgb + (1 - over.a) * c;
        coverage = over.a + (1 - over.a) * coverage;
        if (over.a > 0.5) nearest = max(nearest, eye.w / splat_depth);
    }
    tone = vec4(linear ? (coverage > 0 ? from_srgb(c / coverage) * coverage : vec3(0)) : c,
                coverage);
    gl_FragDepth = nearest;
}
)";

}  // namespace knead
