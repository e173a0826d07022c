// A small user of the headset's five verbs: it clears both eyes, and tells in JSON lines what it
// saw. The checks of faults run it; it needs no clay.
// usage: openxr_probe FRAMES [--egl|--glx] [--patience SECONDS]
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "render/gl.h"
#include "xr/headset.h"

using namespace knead;
using Json = nlohmann::json;

namespace {

void print_line(const Json& line) { std::printf("%s\n", line.dump().c_str()); }

// Clears colour to red at the left and green at the right eye, depth to a half.
void draw(const HeadsetViews& views, unsigned frame)
{
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const EyeTexture& to = views.targets[eye];
        glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, to.colour, 0);
        if (to.depth) glNamedFramebufferTexture(frame, GL_DEPTH_ATTACHMENT, to.depth, 0);
        const float colour[] = {eye == 0 ? 1.f : 0.f, eye == 1 ? 1.f : 0.f, 0, 1}, half = 0.5f;
        glClearNamedFramebufferfv(frame, GL_COLOR, 0, colour);
        if (to.depth) glClearNamedFramebufferfv(frame, GL_DEPTH, 0, &half);
    }
}

Json hand_line(const TrackedHand& hand)
{
    int valid = 0;
    for (const bool one : hand.hand.valid) valid += one;
    return {
        {"tracked", hand.hand.tracked},
        {"valid", valid},
        {"from", int(hand.from)},
        {"wrist",
         {hand.hand.joints[wrist].p.x, hand.hand.joints[wrist].p.y, hand.hand.joints[wrist].p.z}},
        {"radii", {hand.hand.radius[wrist], hand.hand.radius[index_tip]}},
        {"pinch", hand.pinch}};
}

int probe(int frames, const HeadsetOptions& options)
{
    const std::unique_ptr<Headset> headset = Headset::open(options);
    load_gl_functions(headset->gl_address());
    const HeadsetInfo& facts = headset->facts();
    print_line({{"binding", facts.binding},
                {"runtime", facts.runtime},
                {"missing", facts.missing},
                {"hidden", facts.hidden[0].corners.size()},
                {"depth", facts.depth}});
    unsigned target = 0;
    glCreateFramebuffers(1, &target);
    int drawn = 0, errors = 0;
    for (int turn = 0; turn < 100 * frames + 1000; ++turn) {
        const HeadsetEvents events = headset->poll();
        for (const std::string& message : events.messages) print_line({{"message", message}});
        if (events.renewed) print_line({{"renewed", drawn}});
        if (events.recentred) print_line({{"recentred", drawn}});
        if (events.phase == Phase::over) {
            print_line({{"over", events.reason}});
            break;
        }
        if (events.phase != Phase::running) continue;
        const FrameTiming timing = headset->begin();
        const HeadsetViews views = headset->locate();
        if (views.draw) draw(views, target), ++drawn;
        while (glGetError() != 0) ++errors;
        print_line({{"time", timing.time},
                    {"period", timing.period},
                    {"draw", views.draw},
                    {"focused", events.focused},
                    {"worn", events.worn},
                    {"rate", events.rate},
                    {"left", hand_line(views.hands[left])},
                    {"right", hand_line(views.hands[right])}});
        FrameSubmission done;
        done.eyes = views.draw, done.near_z = 0.05f, done.far_z = 100;
        done.vibrate[right] = drawn == 20 ? 0.5f : 0;
        headset->end(done);
        if (drawn == frames) headset->leave();
    }
    glDeleteFramebuffers(1, &target);
    print_line({{"drawn", drawn}, {"errors", errors}, {"stray", headset->stray_gl_errors()}});
    headset->close();
    return 0;
}

}  // namespace

int main(int count, char** words)
{
    HeadsetOptions options;
    options.nap = 0.001;
    int frames = count > 1 ? std::atoi(words[1]) : 30;
    for (int i = 2; i < count; ++i) {
        if (std::strcmp(words[i], "--egl") == 0) options.binding = GlBinding::egl;
        if (std::strcmp(words[i], "--glx") == 0) options.binding = GlBinding::glx;
        if (std::strcmp(words[i], "--patience") == 0) options.patience = std::atof(words[i + 1]);
    }
    return run_and_report([&] { return probe(frames, options); });
}
