// What hands sound like, and that it goes out.
#include "xr/sound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "host/vr/cue_sound.h"
#include "tests/folder.h"

namespace knead {
namespace {

constexpr int ten_ms = CueSound::rate / 100;

struct Heard {
    double left, right;  // root mean square [1]
    double crossings;    // of zero, a second, on the left
    double leap;         // from sample to sample at most
};

Heard listen(CueSound& cues, int frames)
{
    std::vector<std::int16_t> samples;
    cues.make(frames, samples);
    EXPECT_EQ(samples.size(), std::size_t(2 * frames));
    Heard heard{0, 0, 0, 0};
    double before = 0;
    for (int k = 0; k < frames; ++k) {
        const double a = samples[std::size_t(2 * k)] / 32767.0,
                     b = samples[std::size_t(2 * k + 1)] / 32767.0;
        heard.left += a * a, heard.right += b * b;
        heard.crossings += k > 0 && (a < 0) != (before < 0);
        if (k > 0) heard.leap = std::max(heard.leap, std::abs(a - before));
        before = a;
    }
    heard.left = std::sqrt(heard.left / frames), heard.right = std::sqrt(heard.right / frames);
    heard.crossings *= double(CueSound::rate) / frames;
    return heard;
}

TEST(CueSound, IsSilentWhereNothingHappens)
{
    CueSound cues;
    cues.set(left, Feel::nothing, 0.3f);
    const Heard heard = listen(cues, CueSound::rate);
    EXPECT_EQ(heard.left, 0);
    EXPECT_EQ(heard.right, 0);
}

TEST(CueSound, AContactIsAThudThatDiesAway)
{
    CueSound cues;
    cues.set(right, Feel::contact, 0);
    const Heard thud = listen(cues, 6 * ten_ms);
    EXPECT_GT(thud.left, 0.05);
    EXPECT_NEAR(thud.left, thud.right, 1e-3);
    EXPECT_LT(thud.crossings, 400) << "low";
    EXPECT_LT(thud.leap, 0.02) << "no click";
    listen(cues, 60 * ten_ms);
    EXPECT_LT(listen(cues, 5 * ten_ms).left, 1e-3 * thud.left);
}

TEST(CueSound, IsHeardFromWhereTheHandIs)
{
    CueSound cues;
    cues.set(right, Feel::contact, 1);
    const Heard beside = listen(cues, 6 * ten_ms);
    EXPECT_GT(beside.right, 0.05);
    EXPECT_LT(beside.left, 0.01 * beside.right);
    CueSound other;
    other.set(right, Feel::contact, -1);
    const Heard across = listen(other, 6 * ten_ms);
    EXPECT_NEAR(across.left, beside.right, 1e-3);
    CueSound lost;
    lost.set(right, Feel::contact, NAN);
    EXPECT_GT(listen(lost, 6 * ten_ms).left, 0.05);
}

TEST(CueSound, ABladeIsHigherThanClayThatYieldsAndBothEnd)
{
    CueSound soft, sharp;
    Heard yields{}, cuts{};
    for (int k = 0; k < 30; ++k) {
        soft.set(left, Feel::yielding, 0), sharp.set(left, Feel::cutting, 0);
        yields = listen(soft, ten_ms), cuts = listen(sharp, ten_ms);
    }
    EXPECT_GT(yields.left, 0.01);
    EXPECT_GT(cuts.left, 0.01);
    EXPECT_GT(cuts.crossings, 3 * yields.crossings);
    listen(soft, 40 * ten_ms), listen(sharp, 40 * ten_ms);
    EXPECT_LT(listen(soft, ten_ms).left, 1e-3);
    EXPECT_LT(listen(sharp, ten_ms).left, 1e-3);
}

TEST(CueSound, TwoHandsAtOnceStayWithinItsRange)
{
    CueSound cues;
    double most = 0;
    std::vector<std::int16_t> samples;
    for (int k = 0; k < 200; ++k) {
        for (const Side side : {left, right})
            cues.set(side,
                     k % 3 == 0   ? Feel::contact
                     : k % 3 == 1 ? Feel::yielding
                                  : Feel::cutting,
                     0);
        samples.clear();
        cues.make(ten_ms, samples);
        for (const std::int16_t x : samples) most = std::max(most, std::abs(x / 32767.0));
    }
    EXPECT_GT(most, 0.1);
    EXPECT_LT(most, 0.99) << "nothing is cut off";
}

class Sound : public InFolder {};

// OpenAL plays into a file here.
TEST_F(Sound, GoesOutAsItIsMade)
{
    std::ofstream(path("al.conf"))
        << "[general]\ndrivers = wave\nchannels = stereo\n[wave]\nfile = " << path("heard.wav")
        << "\n";
    setenv("ALSOFT_CONF", path("al.conf").c_str(), 1);
    std::string why;
    std::unique_ptr<SoundOut> out = SoundOut::open(why);
    for (const char* missing : {"libopenal.so.1", "built without OpenXR"})
        if (!out && why.find(missing) != std::string::npos) GTEST_SKIP() << why;
    ASSERT_TRUE(out) << why;
    CueSound cues;
    cues.set(right, Feel::contact, 1);
    int made = 0;
    for (int k = 0; k < 60; ++k) {
        out->fill([&](int pairs, std::vector<std::int16_t>& to) {
            made += pairs;
            cues.make(pairs, to);
        });
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    out.reset();
    EXPECT_GT(made, CueSound::rate / 4);
    EXPECT_LT(made, CueSound::rate);
    std::ifstream in(path("heard.wav"), std::ios::binary);
    const std::string wave((std::istreambuf_iterator<char>(in)), {});
    ASSERT_GT(wave.size(), 1000u);
    EXPECT_EQ(wave.substr(0, 4), "RIFF");
    const auto silent = std::count(wave.begin() + 200, wave.end(), '\0');
    EXPECT_LT(silent, 0.95 * double(wave.size())) << "the thud is in it";
}

// ALSA complains by itself of every card that it does not find.
TEST_F(Sound, SaysWhatIsMissingInOneSentenceAndNothingElse)
{
    if (std::getenv("ALSOFT_CONF")) GTEST_SKIP() << "OpenAL has another driver in this process";
    setenv("ALSOFT_DRIVERS", "alsa", 1);
    setenv("ALSOFT_LOGLEVEL", "0", 1);
    std::string why;
    testing::internal::CaptureStderr();
    const std::unique_ptr<SoundOut> out = SoundOut::open(why);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(why.empty(), out != nullptr);
    unsetenv("ALSOFT_DRIVERS");
}

}  // namespace
}  // namespace knead
