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
      workplace(rule.workplace),
      desk(rule.scene, rule.settings)
{
    load_gl(headset->gl_address());
    painter = EyePainter::open(rule.samples);
    make_targets();
    live = std::make_unique<LiveSession>(std::move(scene),
                                         live_rule(rule, [this] { return clock.now(wall()); }));
    live->settle();
    follow_history();
    end.hands.name = "headset";
}

HeadsetLoop::~HeadsetLoop()
{
    live.reset();
    headset->make_current();
    quad.reset();
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
    poke(sight);
    // Nobody shapes what nobody sees: without the headset worn and in view, time stands still.
    const bool runs = news.visible && news.worn && !leaving && !paused;
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

// Another scene, or the same from its start, has its own tools; what was recorded was of the one
// before.
void HeadsetLoop::follow_history()
{
    state = live->state();
    if (state->history == history) return;
    const bool first = history == 0;
    history = state->history;
    if (!state->scene) return;
    const Scene& scene = state->scene->scene;
    const HandsRule rule_now = live_hands(scene);
    hands.set(rule_now);
    if (!scene.has_hands) live->set_hands(rule_now);
    // A stepped session begins each history at 0.
    if (rule.stepped && !first) time = SessionTime(scene.frame_rate);
    ran = ran && !rule.stepped;
    recorded_from = time.time();
    end.hands.frames.clear();
}

// What is drawn moves at any time, what shapes only while time goes on.
void HeadsetLoop::push(HandFrame given, bool runs, double now)
{
    if (anew) given.hand[left].tracked = given.hand[right].tracked = false;
    anew = false;
    given.time = tick.time;
    hands.push(given);
    std::vector<HandFrame>& kept = end.hands.frames;
    given.time = now - recorded_from;
    if (!runs || (!kept.empty() && !(given.time > kept.back().time))) return;
    if (kept.size() >= longest_recording && !recording_full)
        rule.tell("an hour of hands was recorded; what follows is not");
    recording_full = kept.size() >= longest_recording;
    if (recording_full) kept.pop_back();
    kept.push_back(given);
    given.time = now;
    live->push(given);
    ++frames;
}

// Hands to the simulation, which goes on to this frame's time, and its newest state.
void HeadsetLoop::simulate(const Sight& sight, bool runs, FrameParts& parts)
{
    follow_history();
    const double now = time.frame(tick.time, runs && ran);
    ran = runs;
    if (!rule.stepped) clock.set(now, wall(), runs ? tick.period : 0);
    push(hand_frame(sight, workplace, now), runs, now);
    if (rule.stepped && runs) live->advance_to(now);
    const auto before = state;
    state = live->state();
    if (!state->trouble.empty() && before->trouble.empty())
        rule.tell("the simulation has ended: " + state->trouble);
    // The state shows what a hand did when its frame began.
    const double computing = rule.stepped ? 0 : state->frame.times.solver;
    parts.latency = std::max(0.0, now - (state->time - computing));
}

void HeadsetLoop::poke(const Sight& sight)
{
    if (!rule.panel) return;
    const Joint<float> at = HeadsetPanel::pose(rule.workplace, panel_side);
    for (const Side side : {left, right}) {
        const Hand hand = in_hands(workplace, sight.hands[std::size_t(side)].hand);
        const Vec3<float> tip = rotate(conjugate(at.q), hand.joints[index_tip].p - at.p);
        const bool seen = hand.tracked && hand.valid[index_tip];
        if (const auto command = panel.poke(side, tip, seen)) obey(*command, sight);
    }
}

void HeadsetLoop::obey(const PanelCommand& command, const Sight& sight)
{
    panel_age = 0;
    switch (command.act) {
        case PanelAct::pause:
            paused = !paused;
            return;
        case PanelAct::recentre:
            workplace = before_head(head_of(sight), rule.workplace);
            return;
        case PanelAct::side:
            panel_side = panel_side == left ? right : left;
            return;
        case PanelAct::quit:
            leaving = true;
            headset->leave();
            return;
        default:
            desk.apply(command, *state, *live, hands);
            if (rule.stepped) live->settle();
    }
}

void HeadsetLoop::show_state()
{
    static const std::vector<Mesh> nothing;
    const std::vector<int> unseen =
        state->scene ? splat_categories(state->scene->scene) : std::vector<int>();
    painter->set_clay(state->meshes ? *state->meshes : nothing, mesh_version(*state), unseen);
    painter->set_hands(hands.looks());
}

void HeadsetLoop::draw_panel(const EyeView& view, const EyeTarget& to)
{
    constexpr int fine = 3, often = 9;  // texels a pixel; frames from graph to graph
    if (!quad)
        quad = std::make_unique<PanelQuad>(fine * HeadsetPanel::width, fine * HeadsetPanel::height,
                                           to.linear);
    if (panel_age++ % (2 * often) == 0) {  // both eyes count
        PanelView shown = desk.view(*state, hands);
        shown.paused = paused;
        PanelCanvas canvas(HeadsetPanel::width, HeadsetPanel::height, fine);
        panel.draw(canvas, shown, end.figures);
        quad->upload(canvas);
    }
    const Joint<float> at = HeadsetPanel::pose(rule.workplace, panel_side);
    const float x = 0.5f * HeadsetPanel::width * HeadsetPanel::pixel;
    const float y = 0.5f * HeadsetPanel::height * HeadsetPanel::pixel;
    std::array<Vec3<float>, 4> corners{{{-x, y, 0}, {x, y, 0}, {-x, -y, 0}, {x, -y, 0}}};
    for (Vec3<float>& corner : corners)
        corner =
            cast<float>(hands.rule().at) + float(hands.rule().zoom) * (at.p + rotate(at.q, corner));
    quad->draw(corners, view, to);
}

void HeadsetLoop::draw(const Sight& sight)
{
    show_state();
    static const Scene none{};
    const Scene& scene = state->scene ? state->scene->scene : none;
    const EyeLook look = look_of(scene, headset->facts().see_through);
    for (int eye = 0; eye < 2; ++eye) {
        const EyeTexture& to = sight.targets[std::size_t(eye)];
        glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, to.colour, 0);
        glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, to.depth ? to.depth : own_depth, 0);
        const EyeView view = eye_view(sight.eyes[std::size_t(eye)], to.width, to.height, workplace,
                                      hands.rule(), float(rule.nearest));
        const EyeTarget into{target, 0, 0, to.srgb};
        painter->paint(view, look, into, eye);
        if (rule.panel) draw_panel(view, into);
    }
    glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, 0, 0);
    glNamedFramebufferTexture(target, GL_DEPTH_ATTACHMENT, 0, 0);
    while (glGetError() != GL_NO_ERROR) ++end.gl_errors;
    ++end.drawn;
}

}  // namespace knead
