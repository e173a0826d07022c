#include "host/vr/headset_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "host/base/machine.h"
#include "host/ui/panel_commands.h"
#include "host/ui/session_line.h"
#include "host/vr/headset_loop_class.h"

namespace knead {
namespace {

// Limits the time that a frame of a stepped display adds. Otherwise slow frames would become ever
// slower, because each simulates the duration of the previous one.
SessionTime session_time(const Scene& scene, const HeadsetLoopOptions& options)
{
    constexpr double most = 0.25;  // of a frame of the display [s]
    return options.stepped ? SessionTime(scene.frame_rate, most) : SessionTime(scene.frame_rate);
}

}  // namespace

HeadsetLoop::HeadsetLoop(std::shared_ptr<const LiveScene> of, HeadsetLoopOptions by,
                         CallGate& guard)
    : gate(guard),
      first_scene(std::move(of)),
      options(std::move(by)),
      time(session_time(first_scene->scene, options)),
      state(std::make_shared<const LiveState>()),
      hands(live_hands(first_scene->scene)),
      workplace(options.workplace),
      record(options.notify),
      control(in_headset, options.session.empty() ? options.scene : options.session,
              options.settings),
      notices(options.notify, [this](const std::string& text) { control.note(text); }),
      feedback(options.sound && !options.stepped, options.notify)
{
}

void HeadsetLoop::open()
{
    runtime([&] { headset = Headset::open(options.headset); });
    drawing([&] { eyes = std::make_unique<HeadsetEyes>(*headset, EyesOptions::of(options)); });
    if (!eyes->message().empty()) options.notify(eyes->message());
    end.facts = headset->facts();
    LiveOptions lived = live_options(options, [this] { return clock.now(wall_seconds()); });
    const Sharing sharing = eyes->sharing();
    end.shared = lived.on_device = sharing.shared;
    if (!sharing.text.empty()) options.notify(sharing.text);
    if (options.headset.see_through && !headset->facts().see_through)
        options.notify(
            "--see-through: this runtime supports opaque pictures only; the room is not visible");
    live = std::make_unique<LiveSession>(first_scene, std::move(lived));
    live->wait_until_open();
    live->wait_for_commands();
    if (options.protects && options.session.empty())
        recoverable = std::async(std::launch::async, recoverable_sessions);
    floor = headset->facts().floor;
    if (floor == Floor::standing) {
        // A workplace given relative to the floor is used at the start; otherwise, and later, it is
        // placed relative to the head.
        replace_workplace = !(options.workplace.at.y > 0);
        if (!replace_workplace) options.workplace = {};
    }
    control.ui.puts_down = true;
    control.execute = [this](const ControlEvent& event) { execute(event); };
    if (options.protects) control.remember_files();
    follow_history();
    if (options.panel) open_panel();
    if (!options.stepped) rehearse();
}

// With letters that are large enough from where it stands.
void HeadsetLoop::open_panel()
{
    place_panel();
    opened_distance = panel.distance();
    const PanelDrawingOptions layout = HeadsetPanel::layout(opened_distance);
    PanelDrawing* const opened = drawing([&] { return eyes->open_panel(layout); });
    panel.set_drawing(opened);
    if (!opened) options.notify(no_panel);
}

void HeadsetLoop::place_panel()
{
    panel.place(options.workplace, clay_box(*state), hands.options());
    placed_side = control.ui.panel_side, placed_zoom = hands.options().zoom;
}

HeadsetEnd HeadsetLoop::results(const std::string& reason)
{
    finished = true;
    if (end.reason.empty()) end.reason = reason;
    if (live) {
        const ClayDigest clay = live->digest();
        end.hash = clay.hash, end.particles = clay.particles;
    }
    end.state = live ? live->state() : state;  // of the digest's frame or a later one
    if (live) record.add(live->take_applied());
    end.hands = std::move(record.hands), end.commands = std::move(record.commands);
    end.hands.name = "headset";
    end.rate = timing.period > 0 ? 1 / timing.period : 0;
    end.hands.rate = end.rate > 0 ? end.rate : 90;
    end.length = began < 0 ? 0 : wall_seconds() - began;
    end.left_out = time.left_out();
    return std::move(end);
}

void HeadsetLoop::close()
{
    runtime([&] { headset->close(); });
}

void HeadsetLoop::check_end(const HeadsetEvents& events)
{
    const bool enough = options.frames > 0 && frames >= options.frames;
    if (leaving || events.phase == Phase::over || (!enough && !options.should_stop())) return;
    leaving = true;
    runtime([&] { headset->leave(); });
}

// One round of the loop; false when it is over.
bool HeadsetLoop::step()
{
    const HeadsetEvents events = runtime([&] { return headset->poll(); });
    end.runtime_gl_errors = headset->stray_gl_errors();
    visible = events.visible && events.worn;
    lost = events.lost;
    for (const std::string& message : events.messages) options.notify(message);
    if (events.renewed) {
        ++end.sessions_recreated;
        restart_filter = true;
        frame_submitted = false;
        end.facts = headset->facts();
        drawing([&] { eyes->renew(); });
    }
    if (events.phase == Phase::over) {
        end.reason = events.reason;
        return false;
    }
    check_end(events);
    if (events.phase == Phase::running)
        frame();
    else
        ran = false;
    return !finished || leaving;
}

void HeadsetLoop::frame()
{
    FrameParts parts;
    const double start = wall_seconds();
    if (began < 0) began = start;
    timing = runtime([&] { return headset->begin(); });
    const double begun = wall_seconds();
    const HeadsetViews views = runtime([&] { return headset->locate(); });
    const double located = wall_seconds();
    if (replace_workplace && views.located) {
        if (floor != headset->facts().floor)
            options.notify("the runtime offers no STAGE space (floor of the room)");
        floor = headset->facts().floor;
        workplace = before_head(head_of(views), options.workplace);
        replace_workplace = false;
        restart_filter = true;
    }
    newest_views = views;
    follow_panel(views);
    follow_objects(views);
    // The simulation pauses while the headset is not worn or the session not visible.
    const bool runs = visible && !leaving && !finished && !paused;
    simulate(views, runs, parts);
    const double simulated = wall_seconds();
    const bool shown = views.draw && draw(views, parts);
    const double drawn = wall_seconds();
    FrameSubmission done;
    done.eyes = shown, done.scale = parts.scale;
    if (shown) done.near_z = std::numeric_limits<float>::infinity();
    done.far_z = float(options.near_plane);
    feedback.frame(views, *state, hands, done.vibrate);
    for (const Side side : {left, right})
        done.vibrate[side] = std::max(done.vibrate[side], objects.vibration(side));
    runtime([&] {
        parts.left = headset->time_left();
        headset->end(done);
    });
    parts.wait = begun - start, parts.locate = located - begun;
    parts.simulate = simulated - located, parts.draw = drawn - simulated;
    parts.submit = wall_seconds() - drawn, parts.period = timing.period;
    parts.interval = last_shown >= 0 ? timing.time - last_shown : 0;
    last_shown = shown && runs ? timing.time : -1;
    add_times(parts);
    if (shown && runs) end.figures.add(parts);
    frame_submitted = frame_submitted || runs;
}

// After a load or reset: takes the scene's tools and restarts the recording.
void HeadsetLoop::follow_history()
{
    state = live->state();
    if (state->history == history) return;
    const bool first = history == 0;
    history = state->history;
    if (!state->scene) return;
    const Scene& scene = state->scene->scene;
    const HandsOptions options_now = live_hands(scene);
    hands.set(options_now);
    // In a stepped session the time of each history begins at 0.
    if (options.stepped && !first) time = session_time(scene, options);
    record.begin(*state->scene, history, time.time());
    if (!scene.has_hands)
        live->send(hands_command(settings_of(options_now, scene.origin)), Origin::headset);
    ran = ran && !options.stepped;
    mode = HandMode::shape, moving_scene = shapes_after = false, fists = {}, carried.clear();
}

// The drawn hands always follow the tracker; the simulation receives hands only while simulated
// time advances.
void HeadsetLoop::push(HandFrame given, bool runs, double now)
{
    if (restart_filter) given.hand[left].tracked = given.hand[right].tracked = false;
    restart_filter = false;
    given.time = timing.time;
    hands.push(given);
    notices.follow(hands, timing.time);
    if (mode == HandMode::carry) follow_fists(given);
    if (!runs || !record.frame(given, now)) return;
    given.time = now;
    live->push(given);
    ++frames;
}

// Pushes hands, advances the simulation to this frame's time, and fetches the newest state.
void HeadsetLoop::simulate(const HeadsetViews& views, bool runs, FrameParts& parts)
{
    using namespace std::chrono_literals;
    follow_history();
    // The first picture of a session takes longer than others: in real time, time advances only
    // once it was submitted.
    const bool goes_on = runs && (options.stepped || frame_submitted);
    const bool kept_up = time.left_out() == 0;
    const double now = time.frame(timing.time, goes_on && ran);
    if (kept_up && time.left_out() > 0)
        options.notify(
            "a display frame takes longer than a quarter of a second, which is the "
            "maximum that it simulates: simulated time lags behind");
    ran = goes_on;
    if (!options.stepped) clock.set(now, wall_seconds(), goes_on ? timing.period : 0);
    if (goes_on && !std::exchange(started, true)) live->start();
    push(hand_frame(views, workplace, now), goes_on, now);
    if (options.stepped && runs) live->advance_to(now);
    record.add(live->take_applied());
    const auto before = state;
    state = live->state();
    if (!state->failure.empty() && before->failure.empty())
        options.notify("the simulation has ended: " + state->failure);
    notices.follow(*state, timing.time);
    if (recoverable.valid() && recoverable.wait_for(0s) == std::future_status::ready)
        notices.tell(recovery_line(recoverable.get().size()));
    if (options.hands_only || !state->failure.empty()) return;  // no deformation, no latency
    // The state contains the effect of the hands sampled when its frame began.
    const double computing = options.stepped ? 0 : state->frame.times.solver;
    parts.latency = std::max(0.0, now - (state->time - computing));
}

PanelSurroundings HeadsetLoop::surroundings(const HeadsetViews& views) const
{
    PanelSurroundings around;
    around.head = in_hands(workplace, head_of(views)).p;
    for (const Side side : {left, right}) {
        around.hands[side] = in_hands(workplace, views.hands[std::size_t(side)].hand);
        around.busy[side] =
            mode == HandMode::carry || objects.busy() || !hands.options().held[side].empty();
    }
    for (std::size_t k = 0; k < state->tools.size(); ++k)
        if (state->frame.stats.touched & tool_bit(int(k)))
            around.contact[state->tools[k].side] = true;
    return around;
}

void HeadsetLoop::follow_panel(const HeadsetViews& views)
{
    UiState& ui = control.ui;
    ui.paused = paused, ui.hand_mode = mode;
    ui.standing = headset->facts().floor == Floor::standing;
    control.follow(*state, *live, timing.time);  // for the buttons of controllers, too
    if (!panel.exists()) return;
    // Not while fists zoom: it would jump.
    const bool zoomed = !moving_scene && hands.options().zoom != placed_zoom;
    if (ui.panel_side != placed_side || zoomed) place_panel();
    if (panel.distance() > 1.02f * opened_distance) open_panel();
    for (const ControlEvent& event :
         panel.frame(times, surroundings(views), timing.time, timing.period))
        control.apply(event, *live);
    follow_tools();
    if (options.stepped) live->wait_for_commands();
}

// The hands that are drawn hold what the panel has chosen.
void HeadsetLoop::follow_tools()
{
    if (!control.ui.document || control.ui.document == tools_of) return;
    tools_of = control.ui.document;
    HandsOptions options_now = hands.options();
    const std::string(&held)[side_count] = tools_of->hands->held;
    if (options_now.held[left] == held[left] && options_now.held[right] == held[right]) return;
    for (const Side side : {left, right}) options_now.held[side] = held[side];
    hands.set(options_now);
}

void HeadsetLoop::add_times(const FrameParts& parts)
{
    times.add({{"locate", parts.locate},
               {"simulate", parts.simulate},
               {"draw", parts.draw},
               {"submit", parts.submit}});
    constexpr int often = 30;  // interval of the lines of text [frames]
    if (!panel.shows_times() || facts_age++ % often != 0) return;
    std::vector<std::string>& facts = control.ui.facts;
    facts = {state->solver, fmt::format("{:.0f} % of the frame is left, {} frames late",
                                        100 * end.figures.margin(), end.figures.missed())};
    if (parts.scale < 1) facts.push_back(fmt::format("eyes at {:.0f} %", 100 * parts.scale));
}

// The tools are present only while hands shape.
void HeadsetLoop::send_presence()
{
    SetHands command;
    const bool shapes = mode == HandMode::shape;
    command.left.present = shapes && hands.options().present[left];
    command.right.present = shapes && hands.options().present[right];
    if (state->document && state->document->hands->zoom != hands.options().zoom)
        command.zoom = hands.options().zoom;
    live->send(std::move(command), Origin::headset);
}

// The simulation moves what is carried, and without gravity meanwhile.
void HeadsetLoop::follow_fists(const HandFrame& given)
{
    const FistGesture::Answer answer = fists.frame(given, hands.options(), *meshes_of(*state));
    if (answer.let_go) end_carrying();
    if (answer.took) begin_carrying(*answer.took, answer.by);
}

// Takes the objects of a category that are not locked. If all are, the command is refused, with the
// reason.
void HeadsetLoop::begin_carrying(int category, Side by)
{
    if (!state->document) return;
    std::vector<ObjectRef> all;
    carried.clear(), carried_by = by;
    for (const auto& o : state->document->objects) {
        if (o->category != category) continue;
        all.push_back(o->id);
        if (!o->locked) carried.push_back(o->id);
    }
    live->send(Carry{carried.empty() ? all : carried, by, true}, Origin::headset);
}

void HeadsetLoop::end_carrying()
{
    if (!carried.empty()) live->send(Carry{carried, carried_by, false}, Origin::headset);
    carried.clear();
}

// The display's time stands still; the simulation pauses with it. One of hands alone is paused for
// good, so that its log gets a mark only.
void HeadsetLoop::pause(bool on)
{
    paused = on;
    if (options.hands_only)
        live->send(Mark{on ? "pause" : "resume"}, Origin::headset);
    else
        live->send(Pause{on}, Origin::headset);
}

void HeadsetLoop::set_mode(HandMode to)
{
    if (to == mode) return;
    end_carrying();
    objects.stop(*live);
    control.ui.placing.reset();
    mode = control.ui.hand_mode = to, moving_scene = shapes_after = false;
    fists = {}, scene_gesture = {};
    send_presence();
}

// Two fists move, turn and zoom the scene, unless hands hold something. The clay is not affected.
void HeadsetLoop::move_scene(const HeadsetViews& views, const HandAct (&acts)[side_count])
{
    std::optional<std::array<Vec3<double>, 2>> palms;
    const bool free = mode != HandMode::shape && !objects.busy() && !fists.holds();
    if (free && acts[left].fist && acts[right].fist)
        palms = {cast<double>(views.hands[left].hand.joints[palm].p),
                 cast<double>(views.hands[right].hand.joints[palm].p)};
    const auto moved = scene_gesture.frame(palms, {workplace, hands.options().zoom});
    if (moved) {
        panel.keep(workplace, moved->workplace);
        workplace = moved->workplace;
        hands.set_zoom(moved->zoom);
    }
    // Once, because each change restarts the filter of the simulation's hands.
    if (std::exchange(moving_scene, moved.has_value()) && !moving_scene && state->document &&
        state->document->hands->zoom != hands.options().zoom)
        send_presence();
}

// Those of the support hand undo and redo, as its palm does; those of the other hand change what
// hands do. While objects are moved or clay is laid, either cancels.
void HeadsetLoop::follow_buttons(const HandAct (&acts)[side_count])
{
    for (const Side side : {left, right}) {
        const bool now[2] = {acts[side].lower, acts[side].upper};
        for (int k = 0; k < 2; ++k) {
            const bool pressed = now[k] && !std::exchange(buttons[side][k], now[k]);
            if (!pressed || objects.busy()) continue;
            if (side == control.ui.support) {
                control.apply({{k == 0 ? Control::undo : Control::redo, 0}, {}, 0}, *live);
                continue;
            }
            const HandMode to = k == 0 ? HandMode::choose : HandMode::lay;
            set_mode(mode == to ? HandMode::shape : to);
        }
    }
}

void HeadsetLoop::follow_objects(const HeadsetViews& views)
{
    ObjectHands given{{}, {}, false, hands.options(), timing.time, options.stepped};
    const Joint<float> head = in_hands(workplace, head_of(views));
    for (const Side side : {left, right}) {
        TrackedHand found = views.hands[std::size_t(side)];
        found.hand = in_hands(workplace, found.hand);
        if (found.aim) found.aim = in_hands(workplace, *found.aim);
        given.acts[side] = readers[side].frame(side, found, head);
        given.aside[side] = panel.pointer().inside && panel.pointer().side == side;
    }
    follow_buttons(given.acts);
    // Hands that put down an object touch nothing meanwhile.
    if (control.ui.placing && mode == HandMode::shape) {
        std::optional<SceneObject> object = std::exchange(control.ui.placing, {});
        set_mode(HandMode::choose);
        control.ui.placing = std::move(object), shapes_after = true;
    }
    move_scene(views, given.acts);
    for (const Side side : {left, right}) {
        given.aside[side] = given.aside[side] || moving_scene;
        given.cancels =
            given.cancels || (objects.busy() && (given.acts[side].fist || given.acts[side].lower ||
                                                 given.acts[side].upper));
    }
    objects.frame(*state, *live, given);
    if (shapes_after && !control.ui.placing) set_mode(HandMode::shape);
    if (options.stepped) live->wait_for_commands();
}

// What the panel leaves to the headset.
void HeadsetLoop::execute(const ControlEvent& event)
{
    const bool* const given = std::get_if<bool>(&event.value);
    const bool on = given && *given;
    switch (event.id.control) {
        case Control::pause:
            return pause(on);
        case Control::recentre:
            workplace = before_head(head_of(newest_views), options.workplace);
            return;
        case Control::standing:
            floor = on ? Floor::standing : Floor::seated;
            headset->set_floor(floor);
            replace_workplace = true;
            return;
        case Control::carry:
            return set_mode(on ? HandMode::carry : HandMode::shape);
        case Control::choose:
            return set_mode(on ? HandMode::choose : HandMode::shape);
        case Control::lay:
            return set_mode(on ? HandMode::lay : HandMode::shape);
        case Control::quit:
            leaving = true;
            runtime([&] { headset->leave(); });
            return;
        default:
            return;
    }
}

HeadsetPicture HeadsetLoop::picture_of(std::vector<HandLook> looks)
{
    HeadsetPicture picture{*state, std::move(looks), hands.options(), workplace,
                           float(options.near_plane)};
    if (panel.exists())
        picture.panels = panel.shown(), picture.panel_changed = panel.take_changed();
    picture.at_once = options.stepped, picture.now = time.time();
    const double period = timing.period > 0 ? timing.period : EyesOptions::usual_period(options);
    if (!options.stepped && options.min_scale < 1) picture.budget = EyesOptions::gl_share * period;
    return picture;
}

// Resources of the first picture, mostly the skins of hands, take 0.1 to 0.25 s.
void HeadsetLoop::rehearse()
{
    live->rehearse();
    live->wait_for_commands();
    state = live->state();
    std::vector<HandLook> looks = HeadsetHands::open(hands.options()).looks();
    for (HandLook& look : looks) look.opacity = 1;  // opaque hands cast shadows
    if (panel.exists()) {
        control.follow(*state, *live, 0);
        panel.frame(times, {}, 0, 0);
    }
    const HeadsetPicture picture = picture_of(std::move(looks));
    drawing([&] { eyes->rehearse(picture); });
}

// Returns false if drawing fails, with a message the first time.
bool HeadsetLoop::draw(const HeadsetViews& views, FrameParts& parts)
{
    try {
        std::vector<HandLook> looks = hands.looks();
        for (HandLook& mark : objects.looks(*state, hands.options()))
            looks.push_back(std::move(mark));
        const HeadsetPicture picture = picture_of(std::move(looks));
        const EyesDrawn drawn = drawing([&] { return eyes->draw(views, picture); });
        end.gl_errors = eyes->gl_errors();
        parts.scale = drawn.scale, parts.splat_scale = drawn.splat_scale;
        parts.splats = drawn.splats;
    } catch (const std::exception& e) {
        if (draw_error.empty()) options.notify(std::string("drawing failed: ") + e.what());
        draw_error = e.what();
        return false;
    }
    draw_error.clear();
    ++end.drawn;
    return true;
}

std::unique_ptr<HeadsetSession> HeadsetSession::make(std::shared_ptr<const LiveScene> scene,
                                                     const HeadsetLoopOptions& options,
                                                     CallGate& gate)
{
    return std::make_unique<HeadsetLoop>(std::move(scene), options, gate);
}

}  // namespace knead
