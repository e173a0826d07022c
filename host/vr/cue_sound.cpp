#include "host/vr/cue_sound.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knead {
namespace {

constexpr float per_second = 1.0f / CueSound::rate;
constexpr int sustained = CueSound::rate * 6 / 100;  // a rustle that is not renewed [samples]

// Coefficient per sample of a one-pole filter with this time constant [s].
float follows(float seconds) { return 1 - std::exp(-per_second / seconds); }
// Coefficient per sample of a one-pole low-pass with this cutoff frequency [Hz].
float passes(float frequency)
{
    return 1 - std::exp(-2 * std::numbers::pi_v<float> * frequency * per_second);
}

}  // namespace

void CueSound::set(Side side, Feel feel, float right)
{
    Voice& voice = voices[side];
    voice.right = std::isfinite(right) ? std::clamp(right, -1.0f, 1.0f) : 0;
    if (feel == Feel::contact) voice.strike = 1, voice.phase = 0;
    if (feel == Feel::yielding) voice.yield_left = sustained;
    if (feel == Feel::cutting) voice.cut_left = sustained;
}

float CueSound::noise()  // -1 to 1
{
    random ^= random << 13, random ^= random >> 17, random ^= random << 5;  // [Marsaglia 2003]
    return float(random) / 2147483648.0f - 1;
}

float CueSound::sample(Voice& v)
{
    static const float onset = follows(0.002f), fade = follows(0.05f), level = follows(0.03f),
                       dull = passes(300), edge = passes(1500);
    v.thud += onset * (v.strike - v.thud);
    v.strike -= fade * v.strike;
    v.phase += (60 + 80 * v.strike) * per_second;  // falling pitch
    v.phase -= std::floor(v.phase);
    v.yield += level * ((v.yield_left > 0 ? 1.0f : 0.0f) - v.yield);
    v.cut += level * ((v.cut_left > 0 ? 1.0f : 0.0f) - v.cut);
    v.yield_left = std::max(0, v.yield_left - 1), v.cut_left = std::max(0, v.cut_left - 1);
    const float white = noise();
    v.low += dull * (white - v.low), v.lower += dull * (v.low - v.lower);
    v.high += edge * (white - v.high);
    return 0.35f * v.thud * std::sin(2 * std::numbers::pi_v<float> * v.phase) +
           1.2f * v.yield * v.lower + 0.06f * v.cut * (white - v.high);
}

void CueSound::make(int frames, std::vector<std::int16_t>& to)
{
    for (int k = 0; k < frames; ++k) {
        float ear[2] = {0, 0};
        for (Voice& voice : voices) {
            const float value = sample(voice);
            // Equal-power panning.
            const float angle = 0.25f * std::numbers::pi_v<float> * (1 + voice.right);
            ear[0] += std::cos(angle) * value, ear[1] += std::sin(angle) * value;
        }
        for (const float x : ear)
            to.push_back(std::int16_t(std::lround(32767 * std::clamp(x, -1.0f, 1.0f))));
    }
}

}  // namespace knead
