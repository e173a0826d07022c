#include "host/session/headset_loop.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "host/solver/audit.h"
#include "render/gl.h"

namespace knead {
namespace {

constexpr std::size_t longest_recording = 90 * 3600;  // frames

// The clay's history and its mesh, as one number that changes with either.
long mesh_version(const LiveState& state)
{
    return (long(state.history) << 40) + state.mesh_version;
}

EyeLook look_of(const Scene& scene, bool transparent)
{
    EyeLook look;
    look.floor = float(scene.setup.walls.min.y);
    look.transparent = transparent;
    look.floor_seen = !transparent;
    const Vec3<double> low = scene.setup.walls.min, high = scene.setup.walls.max;
    look.stage = {cast<float>(0.5 * (low + high)), float(0.5 * length(high - low))};
    return look;
}

LiveRule live_rule(const HeadsetLoopRule& rule, std::function<double()> clock)
{
    LiveRule live;
    live.make = rule.make;
    live.stepped = rule.stepped;
    live.recorded = rule.recorded;
    live.clock = std::move(clock);
    return live;
}

}  // namespace

double HeadsetLoop::wall() const
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

HeadsetLoop::HeadsetLoop(std::shared_ptr<const LiveScene> scene, HeadsetLoopRule by)
    : rule(std::move(by)),
      headset(Headset::open(rule.headset)),
      time(scene->scene.frame_rate),
      hands(live_hands(scene->scene)),
      workplace(rule.workplace)
{
    load_gl(headset->gl_address());
    painter = EyePainter::open(rule.samples);
    make_targets();
    const bool needs_hands = !scene->scene.has_hands;
    live = std::make_unique<LiveSession>(std::move(scene),
                                         live_rule(rule, [this] { return clock.now(wall()); }));
    if (needs_hands) live->set_hands(hands.rule());
    live->settle();
    end.hands.name = "headset";
}

HeadsetLoop::~HeadsetLoop()
{
    live.reset();
    headset->make_current();
    if (target) glDeleteFramebuffers(1, &target);
    if (own_depth) glDeleteTextures(1, &own_depth);
    painter.reset();
    headset->close();
}

void HeadsetLoop::make_targets()
{
    const HeadsetFacts& facts = headset->facts();
    if (!target) glCreateFramebuffers(1, &target);
    if (own_depth) glDeleteTextures(1, &own_depth);
    own_depth = 0;
    if (facts.depth) return;
    glCreateTextures(GL_TEXTURE_2D, 1, &own_depth);
    glTextureStorage2D(own_depth, 1, GL_DEPTH_COMPONENT32F, facts.width, facts.height);
}

HeadsetEnd HeadsetLoop::run()
{
    while (turn()) {
    }
    end.state = live->state();
    live->ask([&](const Solver& solver) {
        const Setup& rules = solver.rules();
        const Audit found = audit(solver.particles(), rules.materials, rules.lattice.dx);
        end.hash = hexadecimal(found.hash);
    });
    end.hands.rate = tick.period > 0 ? 1 / tick.period : 90;
    end.stray = headset->stray_gl_errors();
    end.facts = headset->facts();
    headset->close();
    return end;
}

void HeadsetLoop::look_for_end(const News& news)
{
    const bool enough = rule.frames > 0 && frames >= rule.frames;
    if (leaving || news.phase == Phase::over || (!enough && !rule.stop())) return;
    leaving = true;
    headset->leave();
}

// One round of the loop; false when it is over.
bool HeadsetLoop::turn()
{
    const News news = headset->poll();
    for (const std::string& message : news.messages) rule.tell(message);
    if (news.renewed) {
        ++end.renewals;
        anew = true;
        headset->make_current();
        make_targets();
    }
    if (news.phase == Phase::over) {
        end.reason = news.reason;
        return false;
    }
    look_for_end(news);
    if (news.phase == Phase::running)
        frame(news);
    else
        ran = false;
    return true;
}

void HeadsetLoop::frame(const News& news)
{
    FrameParts parts;
    const double start = wall();
    tick = headset->begin();
    const double begun = wall();
    const Sight sight = headset->locate();
    const double located = wall();
    // Nobody shapes what nobody sees: without the headset worn and in view, time stands still.
    const bool runs = news.visible && news.worn && !leaving;
    simulate(sight, runs, parts);
    const double simulated = wall();
    if (sight.draw) draw(sight);
    const double drawn = wall();

    Drawn done;
    done.eyes = sight.draw;
    if (sight.draw) done.near_z = std::numeric_limits<float>::infinity();
    done.far_z = float(rule.nearest);
    hands.feel(*state, done.vibrate);
    parts.left = headset->time_left();
    headset->end(done);
    parts.wait = begun - start, parts.locate = located - begun;
    parts.simulate = simulated - located, parts.draw = drawn - simulated;
    parts.submit = wall() - drawn, parts.period = tick.period;
    if (sight.draw && runs) end.figures.add(parts);
}

// Hands to the simulation, which goes on to this frame's time, and its newest state.
void HeadsetLoop::simulate(const Sight& sight, bool runs, FrameParts& parts)
{
    const double now = time.frame(tick.time, runs && ran);
    ran = runs;
    if (!rule.stepped) clock.set(now, wall(), runs ? tick.period : 0);
    if (runs && (frames == 0 || now > end.hands.frames.back().time)) {
        HandFrame given = hand_frame(sight, workplace, now);
        if (anew) given.hand[left].tracked = given.hand[right].tracked = false;
        anew = false;
        live->push(given);
        hands.push(given);
        if (end.hands.frames.size() >= longest_recording && !recording_full)
            rule.tell("an hour of hands was recorded; what follows is not");
        recording_full = end.hands.frames.size() >= longest_recording;
        if (recording_full)
            end.hands.frames.back() = given;
        else
            end.hands.frames.push_back(given);
        ++frames;
    }
    if (rule.stepped && runs) live->advance_to(now);
    const auto before = state;
    state = live->state();
    if (!state->trouble.empty() && (!before || before->trouble.empty()))
        rule.tell("the simulation has ended: " + state->trouble);
    // The state shows what a hand did when its frame began.
    const double computing = rule.stepped ? 0 : state->frame.times.solver;
    parts.latency = now - (state->time - computing);
}

void HeadsetLoop::show_state()
{
    static const std::vector<Mesh> nothing;
    const std::vector<int> unseen =
        state->scene ? splat_categories(state->scene->scene) : std::vector<int>();
    painter->set_clay(state->meshes ? *state->meshes : nothing, mesh_version(*state), unseen);
    painter->set_hands(hands.looks());
}

void HeadsetLoop::draw(const Sight& sight)
{
    show_state();
    const EyeLook look = look_of(state->scene->scene, headset->facts().see_through);
    for (int eye = 0; eye < 2; ++eye) {
        const EyeTexture& to = sight.targets[std::size_t(eye)];
        glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, to.colour, 0);
        glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, to.depth ? to.depth : own_depth, 0);
        const EyeView view = eye_view(sight.eyes[std::size_t(eye)], to.width, to.height, workplace,
                                      hands.rule(), float(rule.nearest));
        painter->paint(view, look, {target, 0, 0, to.srgb}, eye);
    }
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, 0, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, 0, 0);
    while (glGetError() != GL_NO_ERROR) ++end.gl_errors;
    ++end.drawn;
}

}  // namespace knead
