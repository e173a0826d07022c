#include "host/desktop/view_app.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/desktop/key_bindings.h"
#include "host/ui/dropped.h"
#include "host/ui/panel_commands.h"

namespace knead {
namespace {

constexpr double picture_budget = 0.15;  // [s]
constexpr float per_pixel = 0.006f;      // of a drag [rad]

// A twentieth of the shortest way between the walls, as one digit [m].
double usual_press(const LiveScene& scene)
{
    const WallOptions& walls = scene.scene.setup.walls;
    const Vec3<double> room = walls.max - walls.min;
    const double way = std::min({room.x, room.y, room.z}) / 20;
    const double digit = std::pow(10, std::floor(std::log10(way)));
    return std::clamp(std::round(way / digit) * digit, press_range.low, press_range.high);
}

// No multisampling on a software renderer, where every sample is expensive.
int samples_for(const Window& window)
{
    return window.renderer().find("llvmpipe") != std::string::npos ? 1 : 4;
}

}  // namespace

ViewApp::ViewApp(std::unique_ptr<Window> shown_in, std::shared_ptr<const LiveScene> scene,
                 ViewAppOptions by)
    : panel(in_window, by.session.empty() ? scene->scene.path : by.session, by.settings, by.cells),
      options(std::move(by)),
      window(std::move(shown_in)),
      painter(EyePainter::open(samples_for(*window))),
      coarse(CoarsePicture::open()),
      pace(picture_budget, 0.3, 1),
      script(options.script),
      record([this](const std::string& text) { panel.note(text); }),
      session(std::move(scene), live_options()),
      state(session.state()),
      gl_renderer(window->renderer()),
      paused(options.paused)
{
    panel.execute = [this](const ControlEvent& event) { execute(event); };
    if (options.protects) panel.remember_files();
    open_panel();
    clock.run(!paused);
    session.wait_until_open();
    session.wait_for_commands();
    state = session.state();
    follow_history();
    if (!options.dropped.empty()) take_file(options.dropped);
    if (options.protects && options.session.empty())
        recoverable = std::async(std::launch::async, recoverable_sessions);
}

// Again after a lost context, and on a display with another scale.
void ViewApp::open_panel()
{
    drawing.reset();
    PanelDrawingOptions by;
    drawing_scale = float(window->content_scale());
    by.scale = drawing_scale;
    by.clipboard = [this] { return window->clipboard(); };
    by.set_clipboard = [this](const std::string& text) { window->set_clipboard(text); };
    drawing = PanelDrawing::open(by);
    if (!drawing) panel.note(no_panel);
    panel.asks = drawing && options.protects;  // a script has nobody to answer
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
    panel.ui.paused = paused, panel.ui.filming = video != nullptr;
    panel.loses_clay = shaped;
    update_facts();
    panel.follow(*state, session, window_time);
    if (recoverable.valid() && recoverable.wait_for(0s) == std::future_status::ready)
        panel.list_recoverable(recoverable.get()), settling = 3;
    follow_history();
    update_visibility();
    if (input.close_requested()) panel.apply({{Control::quit, 0}, {}, 0}, session);
    if (must_draw(happened)) {
        update_title();
        lay_out_panel(passed, happened);
        for (const std::string& file : input.dropped()) take_file(file);
        const bool any_button =
            input.held(button_left) || input.held(button_right) || input.held(button_middle);
        if (!any_button) buttons_ignored = false;
        const bool transforms = gesture.has_value();
        if (transforms)
            take_transform();
        else if (!drawing || !drawing->keys_taken())
            take_keys();
        const bool dialog = drawing && drawing->popup_open();
        const bool puts_down = !transforms && !dialog && panel.ui.placing && !pressing &&
                               (!drawing || !drawing->mouse_taken());
        if (puts_down)
            take_placing();
        else
            placing_at.reset();
        if (!dialog) hand_x = float(input.x()), hand_y = float(input.y());
        if (nozzle && !input.held(button_left)) end_nozzle(true);
        if (transforms || buttons_ignored)
            pointer.pressed = pressing = false;
        else if (!drawing || (!dialog && (pressing || !drawing->mouse_taken())))
            take_mouse(passed);
        else
            pointer.pressed = pressing = false;
        hover(input.inside() && !any_button && !gesture && !dialog &&
              (!drawing || !drawing->mouse_taken()));
        follow_places();
        if (panel.ui.mouse_hand != hand_controlled) control_hand(panel.ui.mouse_hand);
        simulate();
        draw();
        ++frames, settling = std::max(0, settling - 1);
        last_drawn = window_time;
    } else {
        simulate();
    }
    input.begin_frame();
}

PanelInput ViewApp::panel_input(double passed) const
{
    constexpr std::pair<PanelKey, Key> keys[] = {
        {PanelKey::tab, key_tab},       {PanelKey::backspace, key_backspace},
        {PanelKey::remove, key_delete}, {PanelKey::enter, key_enter},
        {PanelKey::escape, key_escape}, {PanelKey::left, key_left},
        {PanelKey::right, key_right},   {PanelKey::up, key_up},
        {PanelKey::down, key_down},     {PanelKey::home, key_home},
        {PanelKey::end, key_end},       {PanelKey::a, Key('A')},
        {PanelKey::c, Key('C')},        {PanelKey::v, Key('V')},
        {PanelKey::x, Key('X')},        {PanelKey::y, Key('Y')},
        {PanelKey::z, Key('Z')}};
    static_assert(std::size(keys) == panel_key_count);
    PanelInput to;
    to.seconds = passed;
    to.pointer = input.inside(), to.x = float(input.x()), to.y = float(input.y());
    // A button of the panel must not see the end of a drag that began in the picture.
    for (int b = 0; b < button_count && !pressing && !gesture && !buttons_ignored; ++b)
        to.down[std::size_t(b)] = input.held(MouseButton(b)) || input.clicked(MouseButton(b));
    to.wheel = float(input.wheel());
    to.control = input.control(), to.shift = input.shift();
    // All keys of a short press may be up again.
    for (const char letter : {'A', 'C', 'V', 'X', 'Y', 'Z'})
        to.control |= input.pressed({letter, true}) || input.pressed({letter, true, true});
    for (const auto& [theirs, ours] : keys)
        to.keys[std::size_t(theirs)] = input.held(ours) || input.went_down(ours);
    to.keys[std::size_t(PanelKey::enter)] |=
        input.held(key_keypad_enter) || input.went_down(key_keypad_enter);
    to.typed = input.typed();
    return to;
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
    if (window->damaged()) {
        happened = true, still.forget();
        if (float(window->content_scale()) != drawing_scale) open_panel();
    }
    return happened;
}

void ViewApp::lay_out_panel(double passed, bool happened)
{
    if (!drawing) return;
    const bool busy = options.scripted || options.every_frame || happened ||
                      window_time < awake_until || drawing->popup_open();
    if (!refresh.due(panel.model(), busy, *drawing, passed)) return;
    for (const ControlEvent& event :
         drawing->frame(panel.model(), times, panel_input(refresh.take_passed()), window->width(),
                        window->height()))
        panel.apply(event, session);
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
    const bool other = state->version != drawn_version || panel.model() != drawn_model;
    if (happened || other) settling = 3;
    if (other) drawn_version = state->version, drawn_model = panel.model();
    const bool blinks = drawing && drawing->keys_taken() && window_time > last_drawn + blink;
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
    if (gesture) end_transform(false);
    ticks = 0, replay = {};
    time = options.scripted ? 0 : clock.now();
    pushed = -1e30;
    shaped = false;
    record.begin(*state->scene, history, time);
    if (const Scene& of = state->scene->scene; !of.has_hands && opened)
        session.send(hands_command(settings_of(state->hands, of.origin)));
    if (state->scene.get() != shown) {
        shown = state->scene.get();
        panel.ui.press = usual_press(*shown);
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
    drawing.reset(), painter.reset(), coarse.reset();
    still.forget();
    window.reset();
    window = Window::open("Knead", width, height);
    painter = EyePainter::open(samples_for(*window));
    coarse = CoarsePicture::open();
    title.clear();
    open_panel();
    panel.note("The OpenGL context was lost and has been created again.");
}

// What the panel leaves to the window.
void ViewApp::execute(const ControlEvent& event)
{
    const bool* const on = std::get_if<bool>(&event.value);
    switch (event.id.control) {
        case Control::frame_view:
            return fit_camera(panel.ui.chosen);
        case Control::frame_all:
            return fit_camera({});
        case Control::move:
            return begin_transform(TransformKind::move);
        case Control::turn:
            return begin_transform(TransformKind::turn);
        case Control::scale:
            return begin_transform(TransformKind::scale);
        case Control::screenshot:
            wanted.push_back("");
            return;
        case Control::film:
            return film();
        case Control::pause:
            return pause(on ? *on : !paused);
        case Control::advance:
            return step();
        case Control::quit:
            leaves = true;
            return;
        default:
            return;
    }
}

void ViewApp::take_keys()
{
    if (input.pressed({key_escape})) escape();
    for (const ControlEvent& event : pressed_controls(input, panel.model())) {
        // With a hand, the key of a move curls its fingers.
        if (event.id.control == Control::move && panel.ui.mouse_hand) continue;
        // A path or a name is asked for.
        if (std::holds_alternative<std::string>(event.value)) {
            if (drawing) drawing->begin(event.id.control);
            if (event.id.control == Control::rename) panel.ui.open = true;
        } else {
            panel.apply(event, session);
        }
    }
    const double turn = 0.05;  // a frame [rad]
    UiState& ui = panel.ui;
    ui.roll += turn * (input.held_alone(Key('E')) - input.held_alone(Key('Q')));
    ui.tilt += turn * (input.held_alone(Key('T')) - input.held_alone(Key('B')));
}

// Cancels the innermost thing under way.
void ViewApp::escape()
{
    if (drawing && drawing->popup_open() && !panel.asking()) return;  // closed by the panel
    if (panel.decline()) return;
    if (panel.ui.placing) return panel.ui.placing.reset(), panel.ui.notice.clear();
    if (nozzle) return cancelled = true, end_nozzle(false);
    if (pressing) {
        const bool shapes = hand_controlled && pointer.presses() && newest_step() > step_at_press;
        cancelled = true, pointer.pressed = false;
        pointer.cancel();
        if (shapes) panel.apply({{Control::undo, 0}, {}, 0}, session);
        return;
    }
    if (panel.ui.help)
        panel.ui.help = false;
    else
        panel.ui.notice.clear();
}

void ViewApp::step() { stepping = stepping || paused; }

// Its number; -1: no steps are kept.
long ViewApp::newest_step() const
{
    long newest = -1;
    if (state->steps)
        for (const StepInfo& one : *state->steps) newest = std::max(newest, long(one.id));
    return newest;
}

// Opens a scene or a session, adds splats or a mesh; else a notice says why not.
void ViewApp::take_file(const std::string& file)
{
    const auto what = command_for_file(file, *state);
    if (const Refusal* refusal = std::get_if<Refusal>(&what)) return panel.note(refusal->text());
    const Command& command = std::get<Command>(what);
    if (std::holds_alternative<Open>(command))
        panel.apply({{Control::open, 0}, file, 0}, session);
    else
        panel.send(command, session);
}

// Chooses the object under the mouse, beside clay none. `several`: adds it to the chosen ones, or
// takes it away.
void ViewApp::click(float x, float y, bool several)
{
    const int covered = drawing ? drawing->covered() : 0;
    const Vec3<double> ray =
        cast<double>(camera.ray(x, y, window->width(), window->height(), covered));
    watch.find(session, window_time);
    const auto hit = pick(*state, cast<double>(camera.eye()), ray, watch.places.get());
    if (!hit && several) return;
    const ObjectId object = hit ? hit->object : ObjectId{};
    const bool chosen = std::ranges::count(selection(panel.ui), object) > 0;
    panel.apply({{Control::object, int(object.value)},
                 several ? ControlValue(!chosen) : std::monostate(),
                 0},
                session);
    glow_until = window_time + 1.5;
}

// Whether the chosen objects are marked: without a hand, in scenes of several objects; else for a
// moment.
bool ViewApp::shows_chosen() const
{
    if (panel.ui.mouse_hand || !state->document) return false;
    return state->document->objects.size() > 1 || window_time < glow_until;
}

void ViewApp::follow_places()
{
    const bool coloured_now =
        state->document && std::ranges::any_of(state->document->objects,
                                               [](const auto& o) { return bool(o->colour); });
    const bool shown_now =
        (shows_chosen() && panel.ui.chosen.value) || hovered.value || coloured_now;
    watch.follow(*state, session, shown_now, options.scripted, window_time,
                 5e-4 * camera.distance());
}

// Finds the object below the pointer. `free`: the pointer is over the picture, with no button down.
void ViewApp::hover(bool free)
{
    hovered = {};
    if (panel.ui.mouse_hand || !free || !state->scene) return;
    constexpr double fetching = 0.1;  // of a surface on a device, at most so often [s]
    const int covered = drawing ? drawing->covered() : 0;
    if (!state->on_device || window_time >= sought_at + fetching)
        find_surface(cast<double>(camera.eye()),
                     cast<double>(camera.ray(float(input.x()), float(input.y()), window->width(),
                                             window->height(), covered)));
    if (below) hovered = below->object;
}

// Left: the hand presses, or a click chooses; middle, right, or Alt and left: around what is looked
// at; with shift, or Alt and middle: sideways.
void ViewApp::take_mouse(double passed)
{
    const bool shift = input.shift(), control = input.control(), alt = input.alt();
    const float x = float(input.moved_x()), y = float(input.moved_y());
    const bool left_held = input.held(button_left), right_held = input.held(button_right),
               middle_held = input.held(button_middle);
    const bool hand = panel.ui.mouse_hand && !alt, lays = panel.ui.nozzle && (nozzle || !alt);
    constexpr float still_a_click = 4;  // [pixels]
    if (input.clicked(button_left) && !pressing) {
        pressing = true, cancelled = dragged = false;
        step_at_press = newest_step();
        pressed_x = float(input.x()), pressed_y = float(input.y());
    }
    if (lays) take_nozzle(input.clicked(button_left), left_held && !cancelled);
    if (std::hypot(float(input.x()) - pressed_x, float(input.y()) - pressed_y) > still_a_click)
        dragged = true;
    if (pressing && !left_held) {
        pressing = false;
        if (!hand && !lays && !dragged && !cancelled) click(pressed_x, pressed_y, shift || control);
    }
    const bool any_other = middle_held || right_held;
    if (any_other && (shift || (alt && middle_held)))
        camera.pan(x, y, window->height());
    else if (right_held && alt)
        camera.zoom(0.02f * (x - y));
    else if (any_other || (left_held && pressing && !cancelled && !hand && !lays && dragged))
        camera.orbit(-per_pixel * x, per_pixel * y);
    const double wheel = input.wheel();
    if ((!hand && !lays) || control)
        camera.zoom(float(wheel));
    else if (wheel != 0 && lays)
        panel.apply({{Control::nozzle_diameter, 0}, panel.ui.diameter * std::pow(1.1, wheel), 0},
                    session);
    else if (wheel != 0)
        panel.apply(
            {{Control::press, 0},
             std::clamp(panel.ui.press * std::pow(1.1, wheel), press_range.low, press_range.high),
             0},
            session);
    pointer.pressed = hand && pressing && left_held && !cancelled;
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
    pointer.cancel();
    if (!on) return;
    if (state->recorded) panel.send(Play{false}, session);
    SetHands command;
    command.right = {true, hands_now().held[right]};
    panel.send(std::move(command), session);
}

// With what the panel shows that the right hand holds.
HandsOptions ViewApp::hands_now() const
{
    HandsOptions now = state->hands;
    if (panel.ui.document) now.held[right] = panel.ui.document->hands->held[right];
    now.present[right] = true;
    return now;
}

void ViewApp::move_hand()
{
    const UiState& m = panel.ui;
    panel.ui.pointing.clear();
    if (gesture) panel.ui.pointing = gesture->text();
    tracked = {};
    tracked.time = time;
    if (!hand_controlled) return;
    pointer.posture = Posture(m.posture);
    pointer.tilt = m.tilt, pointer.roll = m.roll, pointer.press = m.press;
    // Beyond the range of contact, in a scene of any size.
    if (shown) pointer.gap = 1.5 * shown->scene.setup.lattice.dx;
    Pointing p;
    p.eye = cast<double>(camera.eye());
    p.middle = cast<double>(camera.target());
    const int width = window->width(), height = window->height();
    const int covered = drawing ? drawing->covered() : 0;
    p.rotation = cast<double>(camera.view(width, height).rotation);
    p.ray = cast<double>(camera.ray(hand_x, hand_y, width, height, covered));
    if (!pointer.presses()) find_surface(p.eye, p.ray);
    if (below) p.on = SurfacePoint{below->point, below->normal};
    pointer.aim(p);
    pointer.advance(time);
    PointerHand posed_hand = pointer;
    for (int i = 0; i < 5; ++i) posed_hand.curl[i] = std::max(pointer.curl[i], m.curl[i]);
    tracked = posed_hand.hands(hands_now());
    if (below && !pointer.presses())
        panel.ui.pointing = fmt::format("{:.2g} cm deep", 100 * m.press);
}

// The clay below the pointer: at once where the pointer or the camera has moved, ten times a second
// where only the clay may have.
void ViewApp::find_surface(Vec3<double> eye, Vec3<double> ray)
{
    constexpr double often = 0.1;  // [s]
    const bool moved = length(eye - sought_from) > 0 || length(ray - sought_along) > 0;
    if (!moved && (state->version == sought_in || window_time < sought_at + often)) return;
    sought_from = eye, sought_along = ray, sought_in = state->version, sought_at = window_time;
    below = pick(*state, eye, ray, watch.places.get());
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
