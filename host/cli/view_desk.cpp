#include "host/cli/view_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr double film_rate = 30;                             // pictures per second
constexpr double splat_budget = 0.1, picture_budget = 0.15;  // [s]
constexpr float per_pixel = 0.006f;                          // of a drag [rad]

// knead_0001.png, the first number that is free.
std::string free_name(const std::string& end)
{
    for (int i = 1; i < 10000; ++i) {
        const std::string name = fmt::format("knead_{:04}{}", i, end);
        if (!fs::exists(name)) return name;
    }
    throw OutputError("knead_9999" + end + ": all numbers before it are taken, too");
}

LiveRule live_rule(Device device, bool scripted, bool paused, EyePainter& painter)
{
    LiveRule rule;
    rule.make = [device](const Setup& setup) { return make_solver(setup, device); };
    rule.stepped = scripted;
    rule.paused = paused;
    rule.on_device = device.kind == DeviceKind::cuda && painter.sharing(device.index).shared;
    return rule;
}

// Each pixel of a software renderer costs; edges may then be rough.
int samples_for(const Window& window)
{
    return window.renderer().find("llvmpipe") != std::string::npos ? 1 : 4;
}

}  // namespace

ViewDesk::ViewDesk(std::unique_ptr<Window> shown_in, std::shared_ptr<const LiveScene> scene,
                   Device on, InputScript by, bool with_script, bool paused)
    : panels(scene->scene.path),
      window(std::move(shown_in)),
      painter(EyePainter::open(samples_for(*window))),
      coarse(CoarsePicture::open()),
      pace(picture_budget, 0.3, 1),
      device(on),
      script(std::move(by)),
      scripted(with_script),
      session(std::move(scene), live_rule(on, with_script, paused, *painter)),
      state(session.state())
{
    for (const char* name : posture_names) panels.model.postures.push_back(name);
    session.settle();
}

void ViewDesk::frame(double passed, const std::string& screenshot)
{
    if (!screenshot.empty()) wanted.push_back(screenshot);
    if (scripted) passed = 1 / session.state()->scene->scene.frame_rate;
    time = scripted ? time + passed : session.now();
    listen();
    state = session.state();
    panels.follow(*state);
    panels.model.pass(passed);
    if (state->scene && state->scene.get() != shown) {
        shown = state->scene.get();
        camera.look(cast<float>(shown->scene.eye), cast<float>(shown->scene.target));
        splats.reset();
    }
    tell_facts();
    const PanelAsks asks = window->panels(panels.model, input, passed);
    panels.obey(asks, session, *state);
    if (asks.frame_camera) frame_camera();
    if (asks.film) film();
    if (asks.screenshot) wanted.push_back("");
    if (asks.recorded && *asks.recorded) panels.model.hand = false;
    if (!window->keys_taken()) take_keys();
    if (!window->mouse_taken())
        take_mouse(passed);
    else
        pointer.pressed = false;
    if (panels.model.hand != hand_led) lead_hand(panels.model.hand);
    move_hand(time);
    if (scripted) session.advance_to(time);
    state = session.state();
    if (state->version != counted)
        touched += state->frame.stats.projected, counted = state->version;
    draw();
    ++frames;
}

// A script's events are as a person's.
void ViewDesk::listen()
{
    input.begin_frame();
    for (const InputEvent& event : window->poll()) input.take(event);
    for (const InputEvent& event : script.due(time)) {
        if (event.kind == InputEvent::screenshot) wanted.push_back(event.file);
        if (event.kind == InputEvent::lose) reopen();
        input.take(event);
    }
    if (window->lost()) reopen();
}

// What belonged to a context that was lost is made anew; the session does not notice.
void ViewDesk::reopen()
{
    if (++lost > 3) throw DeviceLost("the OpenGL context was lost again and again");
    const int width = std::max(window->width(), 64), height = std::max(window->height(), 64);
    painter.reset(), coarse.reset();
    window.reset();
    window = Window::open("Knead", width, height);
    painter = EyePainter::open(samples_for(*window));
    coarse = CoarsePicture::open();
    panels.model.note("The OpenGL context was lost, and made anew.");
}

void ViewDesk::take_keys()
{
    PanelModel& m = panels.model;
    if (input.pressed(key_tab)) m.open = !m.open;
    if (input.pressed(key_space)) session.pause(!state->paused);
    if (input.pressed('N')) session.step();
    if (input.pressed('R')) session.reset();
    if (input.pressed('H')) m.hand = !m.hand;
    if (input.pressed('P')) m.posture = (m.posture + 1) % posture_count;
    if (input.pressed('V')) film();
    if (input.pressed(key_home)) frame_camera();
    if (input.pressed(key_f12)) wanted.push_back("");
    if (input.pressed(key_escape)) m.notice.clear();
    const double turn = 0.05;  // a frame [rad]
    m.roll += turn * (input.held(Key('E')) - input.held(Key('Q')));
    m.tilt += turn * (input.held(Key('T')) - input.held(Key('F')));
}

void ViewDesk::take_mouse(double passed)
{
    const bool shift = input.held(key_shift), control = input.held(key_control);
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
    // A finger's key curls it while it is held.
    for (int i = 0; i < 5; ++i) {
        const double way = input.held(Key('1' + i)) || input.held(Key('G')) ? 1 : -1;
        pointer.curl[i] = std::clamp(pointer.curl[i] + 4 * passed * way, 0.0, 1.0);
    }
}

// Tools of the simulation follow the mouse from now on, or the recording again.
void ViewDesk::lead_hand(bool on)
{
    hand_led = on;
    if (!on) return;
    pointer.reach = 0.75 * camera.distance();
    if (state->recorded) session.play(false);
    session.set_hands(panels.hands(*state));
}

void ViewDesk::move_hand(double at)
{
    const PanelModel& m = panels.model;
    pointer.posture = Posture(m.posture);
    pointer.tilt = m.tilt, pointer.roll = m.roll, pointer.press = m.press;
    pointer.advance(at);
    tracked = {};
    tracked.time = at;
    if (hand_led) {
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
    session.push(tracked);
}

void ViewDesk::frame_camera()
{
    Vec3<float> low{1e30f, 1e30f, 1e30f}, high = -low;
    if (state->on_device && !state->on_device->empty())
        low = state->on_device->low(), high = state->on_device->high();
    for (const Mesh& mesh : state->meshes ? *state->meshes : std::vector<Mesh>())
        for (const Vec3<float>& v : mesh.vertices) {
            low = {min(low.x, v.x), min(low.y, v.y), min(low.z, v.z)};
            high = {max(high.x, v.x), max(high.y, v.y), max(high.z, v.z)};
        }
    if (!(low.x <= high.x)) return;
    const int across = std::max(1, window->width() - window->panels_width());
    camera.frame(low, high, float(across) / float(std::max(1, window->height())));
}

void ViewDesk::follow_splats()
{
    if (!state->splats) return splats.reset();
    if (!splats)
        splats = std::make_unique<SplatDrawer>(*state->splats, device, splat_budget);
    else if (state->history != splats_of || state->splat_version != splat_version)
        splats->set(*state->splats);
    splats_of = state->history, splat_version = state->splat_version;
}

void ViewDesk::draw_splats(const EyeView& view, bool whole)
{
    raster_took = 0;
    follow_splats();
    const SplatMotion motion = splat_motion(*state);
    if (!splats || !motion.any()) return painter->set_splats(0, SplatLayer{});
    splats->draw(*painter, {view}, motion, whole);
    raster_took = splats->seconds();
}

void ViewDesk::draw()
{
    const int width = window->width(), height = window->height();
    if (width < 1 || height < 1) return;  // minimised
    const double begin = wall_seconds();
    const EyeView view = camera.view(width, height, window->panels_width());
    std::vector<HandLook> hands = hand_looks(*state);
    EyeLook look;
    if (state->scene) {
        look = live_look(state->scene->scene);
        show_clay(*painter, *state);
        const auto& objects = state->scene->scene.objects;
        if (panels.model.object != selected)
            selected = panels.model.object, glow_until = time + 1.5;
        if (time < glow_until && std::size_t(selected) < objects.size())
            look.highlight = objects[std::size_t(selected)].category;
    }
    // Where the mouse is, as long as no tool is there yet.
    if (hand_led && hands.empty())
        for (HandLook& ghost : tracked_looks(tracked, panels.hands(*state), 0.4f))
            hands.push_back(std::move(ghost));
    painter->set_hands(hands);
    // Pictures that are kept are whole; others may be coarse, to keep up.
    const bool kept = !wanted.empty() || video;
    draw_splats(view, kept);
    coarse->paint(*painter, view, look, kept ? 1 : pace.scale());
    window->draw_panels();
    const double drawn_at = wall_seconds();
    for (const std::string& file : std::exchange(wanted, {})) keep_picture(file);
    if (video && (scripted ? frames / shown->scene.frame_rate : time) >= filmed) {
        if (width == film_width && height == film_height) {
            video->add(window->image());
            filmed += 1 / film_rate;
        } else {
            film();  // ends it: its pictures are of one size
        }
    }
    errors += window->gl_errors();
    const double shown_at = wall_seconds();
    window->show();
    picture_took = drawn_at - begin - raster_took, show_took = wall_seconds() - shown_at;
    if (!kept) pace.took(picture_took + show_took);
    panels.add_times(*state, raster_took, picture_took, show_took);
}

void ViewDesk::keep_picture(const std::string& file)
{
    try {
        const std::string name = file.empty() ? free_name(".png") : file;
        if (write_png(name, window->image(), [] { return interrupted() != 0; }))
            panels.model.note("Wrote " + name);
    } catch (const OutputError& e) {
        panels.model.note(e.what());
        refused = true;
    }
}

void ViewDesk::film()
{
    try {
        if (video) {
            std::exchange(video, nullptr)->close();
            panels.model.note("The film is written.");
        } else if (!Video::available()) {
            panels.model.note("No film: ffmpeg is not on the PATH.");
        } else {
            const std::string name = free_name(".mp4");
            film_width = window->width(), film_height = window->height();
            video = Video::open(name, film_width, film_height, film_rate);
            filmed = scripted ? frames / shown->scene.frame_rate : time;
            panels.model.note("Filming " + name);
        }
    } catch (const OutputError& e) {
        video.reset();
        panels.model.note(e.what());
        refused = true;
    }
    panels.model.filming = video != nullptr;
}

void ViewDesk::end()
{
    if (video) film();
}

void ViewDesk::tell_facts()
{
    std::vector<std::string>& facts = panels.model.facts;
    facts = {
        state->solver, painter->name(),
        fmt::format("frame {}, {:.2f} s simulated", state->frame.number, state->frame.simulated)};
    if (state->shed.behind > 0.05)
        facts.push_back(fmt::format("too slow: {:.1f} s behind, {} frames cut short",
                                    state->shed.behind, state->shed.frames));
    if (pace.scale() < 0.99)
        facts.push_back(
            fmt::format("drawn by {:.0f} % of the pixels a side, to keep up", 100 * pace.scale()));
    if (splats && splats->scale() < 0.99)
        facts.push_back(fmt::format("splats by {:.0f} % of the pixels a side, to keep up",
                                    100 * splats->scale()));
}

std::string ViewDesk::summary() const
{
    const auto last = session.state();
    return fmt::format(
        "{} frames drawn by {}; {} simulated, {:.4g} s, {:.4g} s behind, {} cut short; {} "
        "particle-substeps put out of tools; {} OpenGL errors{}{}\n",
        frames, painter->name(), last->frame.number, last->frame.simulated, last->shed.behind,
        last->shed.frames, touched, errors,
        last->splats ? fmt::format("; {} splats", last->splats->count()) : "",
        last->trouble.empty() ? "" : "; the simulation ended: " + last->trouble);
}

}  // namespace knead
