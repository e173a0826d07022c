#include "host/desktop/view_app.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/ui/panel_commands.h"

namespace knead {
namespace {

constexpr double picture_budget = 0.15;  // [s]
constexpr float per_pixel = 0.006f;      // of a drag [rad]

// No multisampling on a software renderer, where every sample is expensive.
int samples_for(const Window& window)
{
    return window.renderer().find("llvmpipe") != std::string::npos ? 1 : 4;
}

}  // namespace

ViewApp::ViewApp(std::unique_ptr<Window> shown_in, std::shared_ptr<const LiveScene> scene,
                 ViewAppOptions by)
    : panels(scene->scene.path, by.settings, by.cells),
      options(std::move(by)),
      window(std::move(shown_in)),
      painter(EyePainter::open(samples_for(*window))),
      coarse(CoarsePicture::open()),
      pace(picture_budget, 0.3, 1),
      script(options.script),
      record([this](const std::string& text) { panels.model.note(text); }),
      session(std::move(scene), live_options()),
      state(session.state()),
      gl_renderer(window->renderer()),
      paused(options.paused)
{
    for (const char* name : posture_names) panels.model.postures.push_back(name);
    clock.run(!paused);
    session.wait_until_open();
    session.wait_for_commands();
    state = session.state();
    follow_history();
    if (options.protects && options.session.empty())
        recoverable = std::async(std::launch::async, recoverable_sessions);
}

LiveOptions ViewApp::live_options()
{
    LiveOptions live;
    live.make_solver = [device = options.device](const Setup& setup) {
        return make_solver(setup, device);
    };
    live.stepped = live.restarts_time = options.scripted;
    live.paused = options.paused;
    live.memory = options.memory;
    live.session = options.session, live.protects = options.protects;
    live.on_device =
        options.device.kind == DeviceKind::cuda && painter->sharing(options.device.index).shared;
    live.clock = [this] { return clock.now(); };
    live.published = [] { Window::wake(); };
    return live;
}

void ViewApp::frame(double passed, const std::string& screenshot)
{
    using namespace std::chrono_literals;
    if (!screenshot.empty()) wanted.push_back(screenshot);
    if (options.scripted) passed = 1 / session.state()->scene->scene.frame_rate;
    window_time += passed;
    const bool happened = process_input();
    state = session.state();
    panels.follow(*state);
    if (recoverable.valid() && recoverable.wait_for(0s) == std::future_status::ready)
        panels.list_recoverable(recoverable.get()), settling = 3;
    panels.model.paused = paused;
    panels.model.pass(passed);
    follow_history();
    update_visibility();
    if (pending.any() && window_time > pending.until) answer(false);
    if (must_draw(happened)) {
        update_facts();
        apply(window->panels(panels.model, input, passed));
        if (!window->keys_taken()) take_keys();
        if (!window->mouse_taken())
            take_mouse(passed);
        else
            pointer.pressed = false;
        if (panels.model.hand != hand_controlled) control_hand(panels.model.hand);
        simulate();
        draw();
        ++frames, settling = std::max(0, settling - 1);
        last_drawn = window_time;
    } else {
        simulate();
    }
    input.begin_frame();
}

// Waits for events up to event_timeout(), then processes them and those of the script. Returns
// whether there were any.
bool ViewApp::process_input()
{
    bool happened = false;
    for (const InputEvent& event : window->poll(event_timeout()))
        input.take(event), happened = true;
    began = wall_seconds();
    for (const InputEvent& event : script.due(window_time)) {
        if (event.kind == InputEvent::screenshot) wanted.push_back(event.file);
        if (event.kind == InputEvent::lose) recreate_context();
        input.take(event), happened = true;
    }
    if (window->lost()) recreate_context();
    if (window->damaged()) happened = true, still.forget();
    return happened;
}

// Time to wait for events [s]. While the simulation runs, at most 1/120 s: the hand must be pushed
// even if the mouse does not move, and displays without vertical sync are not drawn more often.
double ViewApp::event_timeout() const
{
    constexpr double asleep = 0.1, often = 1.0 / 120;
    if (options.scripted || options.every_frame || !wanted.empty()) return 0;
    if (hidden) return asleep;
    const bool lives = !paused && state->failure.empty();
    const bool busy = lives || video || settling > 0 || window_time < awake_until;
    if (busy) return std::max(0.0, often - (wall_seconds() - began));
    return still.full_resolution() ? asleep : StillPicture::rest / 4;
}

bool ViewApp::must_draw(bool happened)
{
    constexpr double moving = 0.4;  // redrawing of panels after an event [s]
    constexpr double blink = 0.25;  // of the text cursor in a panel [s]
    if (options.scripted || options.every_frame) return true;
    if (hidden) return !wanted.empty();
    if (happened) awake_until = window_time + moving;
    const PanelModel& m = panels.model;
    const std::string text = m.failure + '\n' + m.notice + '\n' + m.question;
    const bool other = state->version != drawn_version || text != drawn_text;
    if (happened || other) settling = 3;
    drawn_version = state->version, drawn_text = text;
    const bool blinks = window->keys_taken() && window_time > last_drawn + blink;
    const bool glows = last_drawn < glow_until;
    return other || blinks || glows || video || settling > 0 || !wanted.empty() ||
           window_time < awake_until || still.due(window_time);
}

// Pauses the simulation while the window is minimised, as for a headset that is not worn.
void ViewApp::update_visibility()
{
    if (options.scripted || options.every_frame) return;
    const bool seen = window->visible();
    if (seen != hidden) return;
    hidden = !seen;
    if (seen) still.forget(), awake_until = window_time + 0.4;
    clock.run(!paused && !hidden);
    if (!paused) session.send(Pause{hidden});
}

void ViewApp::pause(bool on)
{
    if (on == paused) return;
    paused = on;
    clock.run(!paused && !hidden);
    if (hidden) return;
    session.send(Pause{on});
}

// Whether commands have changed clay or gravity since the scene was opened.
bool ViewApp::clay_changed() const
{
    if (!state->document || !opened) return false;
    const Vec3<double> change = state->document->scene->gravity - opened->scene->gravity;
    return state->document->objects != opened->objects || length(change) > 0;
}

// After a load or reset: restarts the recording; the mouse keeps control of the hand.
void ViewApp::follow_history()
{
    if (!state->scene) return;
    if (state->history == history) {
        shaped = shaped || clay_changed();
        return;
    }
    history = state->history, opened = state->document;
    ticks = 0, replay = {};
    time = options.scripted ? 0 : clock.now();
    pushed = -1e30;
    shaped = false;
    record.begin(*state->scene, history, time);
    if (const Scene& of = state->scene->scene; !of.has_hands && opened)
        session.send(hands_command(settings_of(state->hands, of.origin)));
    if (state->scene.get() != shown) {
        shown = state->scene.get();
        camera.look(cast<float>(shown->scene.eye), cast<float>(shown->scene.target));
        splats.reset();
    }
    if (hand_controlled) control_hand(true);
}

// Recreates everything that belonged to a lost context. The session is not affected.
void ViewApp::recreate_context()
{
    const double now = options.scripted ? window_time : wall_seconds();
    if (losses.too_many(now)) throw DeviceLost("the OpenGL context was lost too often");
    const int width = std::max(window->width(), 64), height = std::max(window->height(), 64);
    painter.reset(), coarse.reset();
    still.forget();
    window.reset();
    window = Window::open("Knead", width, height);
    painter = EyePainter::open(samples_for(*window));
    coarse = CoarsePicture::open();
    panels.model.note("The OpenGL context was lost and has been created again.");
}

void ViewApp::apply(PanelRequests requests)
{
    if (requests.reset) discard({.reset = true});
    const PanelModel& m = panels.model;
    if (requests.load) discard({.load = *requests.load}, m.scenes.at(std::size_t(*requests.load)));
    const auto row = [&](int i) { return m.recoverable.at(std::size_t(i)); };
    if (requests.recover)
        discard({.recover = row(*requests.recover).file}, row(*requests.recover).name);
    if (requests.discard_log)
        discard({.log = row(*requests.discard_log).file}, row(*requests.discard_log).name);
    if (requests.confirm) answer(*requests.confirm);
    if (requests.pause) pause(*requests.pause);
    if (requests.step) step();
    if (requests.fit_camera) fit_camera();
    if (requests.film) film();
    if (requests.screenshot) wanted.push_back("");
    if (requests.recorded && *requests.recorded) panels.model.hand = false;
    panels.apply(requests, session);
}

void ViewApp::take_keys()
{
    PanelModel& m = panels.model;
    if (input.pressed_alone(key_tab)) m.open = !m.open;
    if (input.pressed_alone(key_space)) pause(!paused);
    if (input.pressed_alone('N')) step();
    if (input.pressed_alone('R')) discard({.reset = true});
    PanelRequests by_key;
    by_key.undo = input.pressed_control('Z');
    by_key.redo = input.pressed_control('Y') || input.pressed_control('Z', true);
    by_key.save = input.pressed_control('S');
    panels.apply(by_key, session);
    if (input.pressed_alone('H')) m.hand = !m.hand;
    if (input.pressed_alone('P')) m.posture = (m.posture + 1) % posture_count;
    if (input.pressed_alone('V')) film();
    if (input.pressed_alone(key_home)) fit_camera();
    if (input.pressed_alone(key_f12)) wanted.push_back("");
    if (input.pressed_alone(key_escape)) pending.any() ? answer(false) : m.notice.clear();
    const double turn = 0.05;  // a frame [rad]
    m.roll += turn * (input.held_alone(Key('E')) - input.held_alone(Key('Q')));
    m.tilt += turn * (input.held_alone(Key('T')) - input.held_alone(Key('F')));
}

void ViewApp::step() { stepping = stepping || paused; }

// Whether something would be lost, or is not saved. Undo takes a reset back where there are steps;
// a session with a log can be recovered.
bool ViewApp::confirms(const Discard& what) const
{
    if (!what.log.empty()) return true;
    const bool keeps_steps = state->situation.no_steps.empty();
    if (what.reset) return shaped && !keeps_steps;
    return state->unsaved || (shaped && (!keeps_steps || state->log.file.empty()));
}

// What would be missed is discarded only when the command is repeated. `name`: of what is opened or
// deleted.
void ViewApp::discard(Discard what, const std::string& name)
{
    constexpr double confirm_time = 8;  // [s]
    const bool again = what.reset == pending.reset && what.load == pending.load &&
                       what.recover == pending.recover && what.log == pending.log;
    if (!confirms(what) || again) return do_discard(what);
    PanelModel& m = panels.model;
    m.answer = what.reset ? "Reset" : what.load >= 0 ? "Open" : "Recover";
    m.decline = "Keep the clay";
    std::string lost = state->unsaved ? "This session is not saved; it can be recovered."
                                      : "The shaped clay will be lost.";
    if (!what.log.empty()) {
        m.answer = "Discard", m.decline = "Keep the session";
        lost = "It cannot be recovered then.";
    }
    m.question = m.answer + (what.reset ? "" : " \"" + name + "\"") + "? " + lost +
                 " Repeat the command to confirm.";
    pending = what;
    pending.until = window_time + confirm_time;
    panels.show_scene(*state);
}

void ViewApp::do_discard(const Discard& what)
{
    if (!what.log.empty()) {
        panels.discard_log(what.log);
        return answer(false);
    }
    if (what.reset)
        session.send(Reset{});
    else if (!what.recover.empty())
        panels.recover(what.recover, session);
    else
        panels.load(what.load, session);
    // Before the first frame, so that recorded hands do not move the tools.
    if (hand_controlled) session.send(Play{false});
    answer(false);
}

void ViewApp::answer(bool yes)
{
    const Discard what = std::exchange(pending, {});
    panels.model.question.clear();
    if (yes && what.any()) do_discard(what);
}

void ViewApp::take_mouse(double passed)
{
    const bool shift = input.shift(), control = input.control();
    const float x = float(input.moved_x()), y = float(input.moved_y());
    const bool right_held = input.held(button_right);
    if (input.held(button_middle) || (right_held && shift))
        camera.pan(x, y, window->height());
    else if (right_held || (input.held(button_left) && !panels.model.hand))
        camera.orbit(-per_pixel * x, per_pixel * y);
    if (panels.model.hand && !control)
        pointer.reach = std::max(0.01, pointer.reach + 0.02 * camera.distance() * input.wheel());
    else
        camera.zoom(float(input.wheel()));
    pointer.pressed = panels.model.hand && input.held(button_left);
    // The key of a finger curls it while held.
    for (int i = 0; i < 5; ++i) {
        const bool bends = input.held_alone(Key('1' + i)) || input.held_alone(Key('G'));
        const double way = bends ? 1 : -1;
        pointer.curl[i] = std::clamp(pointer.curl[i] + 4 * passed * way, 0.0, 1.0);
    }
}

// Switches control of the tools to the mouse, or ends it.
void ViewApp::control_hand(bool on)
{
    hand_controlled = on;
    if (!on) return;
    pointer.reach = 0.75 * camera.distance();
    if (state->recorded) session.send(Play{false});
    panels.send_tool(session);
}

void ViewApp::move_hand()
{
    const PanelModel& m = panels.model;
    pointer.posture = Posture(m.posture);
    pointer.tilt = m.tilt, pointer.roll = m.roll, pointer.press = m.press;
    pointer.advance(time);
    tracked = {};
    tracked.time = time;
    if (!hand_controlled) return;
    PointerHand posed_hand = pointer;
    for (int i = 0; i < 5; ++i) posed_hand.curl[i] = std::max(pointer.curl[i], m.curl[i]);
    Pointing p;
    p.eye = cast<double>(camera.eye());
    const int width = window->width(), height = window->height();
    p.rotation = cast<double>(camera.view(width, height).rotation);
    p.ray = cast<double>(
        camera.ray(float(input.x()), float(input.y()), width, height, window->panels_width()));
    tracked = posed_hand.hands(p, panels.hands(*state));
}

// Pushes hands, and with a script advances the simulation to this frame's time.
void ViewApp::simulate()
{
    if (options.scripted) {
        session.wait_for_commands();  // completes a load or reset
        state = session.state();
        follow_history();
    }
    const bool single = std::exchange(stepping, false);
    const bool runs = single || (!paused && !hidden);
    const double rate = state->scene ? state->scene->scene.frame_rate : 90;
    if (options.scripted) time = double(ticks += runs) / rate;
    if (!options.scripted && single) clock.add(1 / rate);
    if (!options.scripted) time = clock.now();
    move_hand();
    // At most 125 frames per second; no tracker has more.
    if (runs && (options.scripted || single || time >= pushed + 0.008)) {
        pushed = time;
        record_hands();
        session.push(tracked);
        shaped = shaped || hand_controlled;
    }
    if (single) session.send(Advance{1});
    if (options.scripted && runs) session.advance_to(time);
    record.add(session.take_applied());
    state = session.state();
    if (state->version != counted)
        touched += state->frame.stats[Count::projected], counted = state->version;
}

// Records the hands that the simulation uses: the mouse's, or those of the scene's recording, which
// may be delayed.
void ViewApp::record_hands()
{
    if (!state->recorded || !state->scene || !state->scene->recording) {
        record.frame(tracked, time);
        return;
    }
    const std::vector<HandFrame>& all = state->scene->recording->frames;
    // Recording time: with a script at the end of the next frame, otherwise of the last.
    const double now = state->recording_time + (options.scripted ? 1 / shown->scene.frame_rate : 0);
    if (now < replay.at) replay = {};  // restarted
    replay.at = now;
    // Simulation frames begin irregularly, frames of the recording regularly: smaller shifts are
    // ignored.
    constexpr double held_up = 0.1;  // [s]
    const double shift = options.scripted ? time - now : state->time - now;
    if (std::abs(shift - replay.shift) > (options.scripted ? 1e-9 : held_up)) replay.shift = shift;
    // Up to the first one that is not before the frame's end: interpolation needs both neighbours.
    while (replay.next < all.size() && (replay.next == 0 || all[replay.next - 1].time < now)) {
        record.frame(all[replay.next], all[replay.next].time + replay.shift);
        ++replay.next;
    }
}

std::string ViewApp::summary() const
{
    const auto last = session.state();
    return fmt::format(
        "{} frames drawn by {}; {} simulated, {:.4g} s, {:.4g} s behind, {} cut short; {} "
        "particle-substeps put out of tools; {} OpenGL errors{}{}\n",
        frames, gl_renderer, last->frame.number, last->frame.simulated, last->backlog.missing_time,
        last->backlog.frames, touched, errors,
        last->splats ? fmt::format("; {} splats", last->splats->count()) : "",
        last->failure.empty() ? "" : "; the simulation ended: " + last->failure);
}

LiveResults ViewApp::results()
{
    session.wait_for_commands();
    record.add(session.take_applied());
    session.send(Pause{true});
    session.wait_for_commands();
    LiveResults of;
    of.clay = session.digest();
    of.state = session.state();
    of.hands = std::move(record.hands), of.commands = std::move(record.commands);
    of.hands.name = "window";
    of.hands.rate = of.state->scene ? of.state->scene->scene.frame_rate : 90;
    return of;
}

}  // namespace knead
