// Drawing of a state in the window of `knead view`; saving of pictures and films.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/desktop/view_app.h"
#include "host/picture/outline.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr double film_rate = 30;      // pictures per second
constexpr double splat_budget = 0.1;  // [s]

// The first unused name of the form knead_0001.png.
std::string free_name(const std::string& end)
{
    for (int i = 1; i < 10000; ++i) {
        std::string name = fmt::format("knead_{:04}{}", i, end);
        if (!fs::exists(name)) return name;
    }
    throw OutputError("knead_9999" + end + ": no unused file name is left");
}

// The columns from `left` on, at most `width` wide: means of boxes of pixels.
Image reduced(const Image& from, int left, int width)
{
    left = std::clamp(left, 0, std::max(0, from.width - 64));
    const int wide = from.width - left;
    Image to{std::min(width, wide), 0, {}};
    to.height = std::max(1, int(std::lround(double(from.height) * to.width / wide)));
    for (int y = 0; y < to.height; ++y)
        for (int x = 0; x < to.width; ++x) {
            const int x0 = left + x * wide / to.width, x1 = left + (x + 1) * wide / to.width;
            const int y0 = y * from.height / to.height, y1 = (y + 1) * from.height / to.height;
            long sum[3] = {0, 0, 0};
            for (int j = y0; j < y1; ++j)
                for (int i = x0; i < x1; ++i)
                    for (int k = 0; k < 3; ++k)
                        sum[k] += from.rgb[std::size_t(3) * std::size_t(j * from.width + i) +
                                           std::size_t(k)];
            for (const long each : sum)
                to.rgb.push_back(std::uint8_t(each / std::max(1, (x1 - x0) * (y1 - y0))));
        }
    return to;
}

}  // namespace

// Shows the clay of the object's category; of no object: all clay.
void ViewApp::fit_camera(ObjectId chosen)
{
    const SceneObject* const object = state->document ? state->document->find(chosen) : nullptr;
    Box3<float> box = empty_box<float>();
    if (object) {
        for (const Mesh& mesh : *meshes_of(*state))
            for (const Vec3<float>& v : mesh.vertices)
                if (mesh.category == object->category) grow(box, v);
    } else if (state->on_device && !state->on_device->empty()) {
        box = state->on_device->box();
    }
    if (empty(box))
        for (const Mesh& mesh : state->meshes ? *state->meshes : std::vector<Mesh>())
            for (const Vec3<float>& v : mesh.vertices) grow(box, v);
    if (empty(box)) return;
    const int covered = drawing ? drawing->covered() : 0;
    const int across = std::max(1, window->width() - covered);
    camera.frame(box, float(across) / float(std::max(1, window->height())));
}

void ViewApp::follow_splats()
{
    if (!state->splats) return splats.reset();
    if (!splats)
        splats = std::make_unique<SplatDrawer>(*state->splats, options.device, splat_budget);
    else if (state->history != splats_of || state->splat_version != splat_version)
        splats->set(*state->splats);
    splats_of = state->history, splat_version = state->splat_version;
}

void ViewApp::draw_splats(const EyeView& view, bool full_resolution)
{
    raster_took = 0;
    follow_splats();
    const SplatMotion motion = splat_motion(*state);
    if (!splats || !motion.any() || splats_hidden(*state))
        return painter->set_splats(0, SplatLayer{});
    splats->draw(*painter, {view}, motion, full_resolution);
    raster_took = splats->seconds();
}

void ViewApp::draw()
{
    const int width = window->width(), height = window->height();
    if (width < 1 || height < 1) return;  // minimised
    const EyeView view = camera.view(width, height, drawing ? drawing->covered() : 0);
    std::vector<HandLook> hands = hand_looks(*state);
    EyeLook look;
    if (state->scene) {
        look = live_look(state->scene->scene);
        follow_colours();
        show_clay(*painter, *state, &colours);
        if (panel.ui.chosen != glowing) glowing = panel.ui.chosen, glow_until = window_time + 1.5;
        const SceneObject* const chosen =
            state->document ? state->document->find(panel.ui.chosen) : nullptr;
        // A surface is that of a category: it glows if all its objects are chosen.
        const std::vector<ObjectId> all = selection(panel.ui);
        if (window_time < glow_until && chosen &&
            std::ranges::all_of(state->document->objects, [&](const auto& o) {
                return o->category != chosen->category || std::ranges::count(all, o->id) > 0;
            }))
            look.highlight = chosen->category;
    }
    // A translucent hand at the mouse until a tool is active.
    if (hand_controlled && hands.empty()) {
        HandFrame seen = tracked;
        seen.hand[pointer.side].tracked = true;
        for (HandLook& ghost : tracked_looks(seen, hands_now(), 0.4f))
            hands.push_back(std::move(ghost));
    }
    const bool aims = hand_controlled ? !pointer.presses() : panel.ui.nozzle && !nozzle && !gesture;
    if (aims && below) hands.push_back(ring());
    PictureContent content = picture_content(view, look);
    content.hands.push_back(float(colours.version % 8388593));
    const bool puts_down = placing_at && panel.ui.placing;
    for (HandLook& lines : gesture ? transform_looks() : puts_down ? placing_looks() : outlines()) {
        for (const Vec3<float>& p : lines.skins.front().vertices)
            for (const float x : {p.x, p.y, p.z}) content.hands.push_back(x);
        content.hands.push_back(lines.glow.x);
        hands.push_back(std::move(lines));
    }
    still.update(std::move(content), window_time);
    paint(view, look, std::move(hands));
}

void ViewApp::follow_colours()
{
    const long version = clay_version(*state);
    if (version == coloured && state->document == colours_of && watch.places == colours_at) return;
    coloured = version, colours_of = state->document, colours_at = watch.places;
    const bool known = watch.places && watch.places->history == history;
    colours = clay_colours(*state, known ? watch.places.get() : nullptr);
}

// Around the chosen objects, and the one below the pointer.
std::vector<HandLook> ViewApp::outlines() const
{
    std::vector<HandLook> all;
    const double thick = 0.003 * camera.distance();
    const auto add = [&](ObjectId object, Vec3<float> colour) {
        const SceneObject* const o = state->document ? state->document->find(object) : nullptr;
        const Box3<double>* const box = watch.box(object);
        if (!o || o->hidden || !box) return;
        all.push_back(mark_look(box_corners(*box, thick), colour));
    };
    const std::vector<ObjectId> chosen = selection(panel.ui);
    if (shows_chosen())
        for (const ObjectId id : chosen) add(id, chosen_colour);
    if (hovered.value && (!shows_chosen() || !std::ranges::count(chosen, hovered)))
        add(hovered, hovered_colour);
    return all;
}

// Around the point that a press begins at, on the surface.
HandLook ViewApp::ring() const
{
    constexpr int pieces = 32;
    const double across = panel.ui.nozzle ? panel.ui.diameter / 2 : 0.02 * camera.distance(),
                 thick = 0.0012 * camera.distance();
    const Vec3<double> n = below->normal, u = orthogonal(n), v = cross(n, u);
    const auto at = [&](int i) {
        const double angle = 2 * std::numbers::pi * i / pieces;
        const Vec3<double> x =
            below->point + across * (std::cos(angle) * u + std::sin(angle) * v) + 2 * thick * n;
        Sphere<float> ball{};
        ball.c = cast<float>(x), ball.r = float(thick);
        return ball;
    };
    HandLook look;
    for (int i = 0; i < pieces; ++i) look.primitives.push_back({2, {at(i), at(i + 1), {}}});
    look.skin = false, look.glow = {0.1f, 0.6f, 1.5f};
    return look;
}

PictureContent ViewApp::picture_content(const EyeView& view, const EyeLook& look) const
{
    constexpr float unseen = 0.25f;  // largest invisible motion [pixels]
    PictureContent seen;
    seen.view = view;
    seen.history = state->history, seen.highlight = look.highlight;
    seen.splat_version = state->splat_version;
    if (state->document) seen.hidden = state->document->hidden_categories();
    seen.meshes = state->meshes, seen.on_device = state->on_device;
    seen.gaussians = state->gaussians, seen.gaussians_on_device = state->gaussians_on_device;
    const auto add = [&](Vec3<float> p) {
        for (const float x : {p.x, p.y, p.z}) seen.hands.push_back(x);
    };
    bool any = false;
    for (const LiveTool& tool : state->tools) any = any || tool.active;
    if (any)
        for (const Joint<double>& joint : state->frame.motion.to) add(cast<float>(joint.p));
    else if (hand_controlled)
        for (const Joint<float>& joint : tracked.hand[right].joints) add(joint.p);
    seen.within = unseen * camera.distance() * (view.up - view.down) / float(view.height);
    return seen;
}

// Saved pictures and those without motion have full resolution; others may be coarser to keep up.
void ViewApp::paint(const EyeView& view, const EyeLook& look, const std::vector<HandLook>& hands)
{
    const double begin = wall_seconds();
    const bool kept = !wanted.empty() || video, lives = !kept && !options.scripted;
    const bool repeats = lives && still.full_resolution(), rests = lives && still.due(window_time);
    raster_took = 0;
    if (repeats) {
        coarse->repeat();
    } else {
        painter->set_hands(hands);
        draw_splats(view, kept || rests);
        coarse->paint(*painter, view, look, kept || rests ? 1 : pace.scale(), rests);
        if (rests) still.drawn_full(), settling = 2;  // a panel shows the resolution
    }
    keep_picture();
    if (drawing) drawing->draw(0);
    const double drawn_at = wall_seconds();
    save_pictures();
    errors += window->gl_errors();
    const double shown_at = wall_seconds();
    window->show();
    picture_took = drawn_at - begin - raster_took, show_took = wall_seconds() - shown_at;
    if (!kept && !repeats && !rests) pace.took(picture_took + show_took);
    add_times();
}

// For the session's list: at most one in ten seconds, after a new step, without the panels and the
// part of the picture behind them. The log gets it when another thread has encoded it.
void ViewApp::keep_picture()
{
    using namespace std::chrono_literals;
    constexpr double every = 10;  // [s]
    constexpr int across = 256;   // [pixels]
    if (state->log.file.empty() || !state->steps || state->steps == kept_steps) return;
    if (std::min(window->width(), window->height()) < 64) return;
    if (state->steps->size() < 2 || window_time < kept_at + every) return;
    if (encoding.valid() && encoding.wait_for(0s) != std::future_status::ready) return;
    kept_at = window_time, kept_steps = state->steps;
    encoding = std::async(std::launch::async, [this, left = drawing ? drawing->covered() : 0,
                                               image = window->image()] {
        try {
            session.set_picture(png_bytes(reduced(image, left, across)));
        } catch (const std::exception&) {  // a session without a picture is valid
        }
    });
}

void ViewApp::save_pictures()
{
    for (const std::string& file : std::exchange(wanted, {})) save_picture(file);
    if (!video || window_time < filmed) return;
    if (window->width() == film_width && window->height() == film_height) {
        video->add(window->image());
        filmed += 1 / film_rate;
    } else {
        film();  // ends the film: its pictures have one size
    }
}

void ViewApp::save_picture(const std::string& file)
{
    try {
        const std::string name = file.empty() ? free_name(".png") : file;
        if (write_png(name, window->image(), [] { return interrupted() != 0; }))
            panel.note("Wrote " + name);
    } catch (const OutputError& e) {
        panel.note(e.what());
        refused = true;
    }
}

void ViewApp::film()
{
    try {
        if (video) {
            std::exchange(video, nullptr)->close();
            panel.note("The film is written.");
        } else if (!Video::available()) {
            panel.note("No film: ffmpeg is not on the PATH.");
        } else {
            const std::string name = free_name(".mp4");
            film_width = window->width(), film_height = window->height();
            video = Video::open(name, film_width, film_height, film_rate);
            filmed = window_time;
            panel.note("Filming " + name);
        }
    } catch (const OutputError& e) {
        video.reset();
        panel.note(e.what());
        refused = true;
    }
}

void ViewApp::end()
{
    if (video) film();
}

// Of a picture and, once per version of the state, of its simulation frame.
void ViewApp::add_times()
{
    TimeGraph::Stages stages;
    if (state->version != timed && state->frame.number > 0) {
        for (const StageTime& stage : state->stages) stages.push_back({stage.name, stage.seconds});
        if (state->stages.empty()) stages.push_back({"solver", state->frame.times.solver});
        stages.push_back({"surface", state->frame.times.surface});
    }
    timed = state->version;
    if (raster_took > 0) stages.push_back({"splats", raster_took});
    stages.push_back({"picture", picture_took});
    stages.push_back({"show", show_took});
    times.add(stages);
}

void ViewApp::update_title()
{
    const fs::path of = state->saved_as.empty() ? panel.ui.scene : state->saved_as;
    std::string text =
        fmt::format("{}{} - Knead", of.filename().string(), state->unsaved ? "*" : "");
    if (text == title) return;
    title = std::move(text);
    window->set_title(title);
}

void ViewApp::update_facts()
{
    std::vector<std::string>& facts = panel.ui.facts;
    facts = {
        state->solver, gl_renderer,
        fmt::format("frame {}, {:.2f} s simulated", state->frame.number, state->frame.simulated)};
    if (state->backlog.missing_time > 0.05)
        facts.push_back(fmt::format("too slow: {:.1f} s behind, {} frames cut short",
                                    state->backlog.missing_time, state->backlog.frames));
    if (pace.scale() < 0.99 && !still.full_resolution())
        facts.push_back(
            fmt::format("picture at {:.0f} % resolution, to keep up", 100 * pace.scale()));
    if (splats && splats->scale() < 0.99)
        facts.push_back(
            fmt::format("splats at {:.0f} % resolution, to keep up", 100 * splats->scale()));
}

}  // namespace knead
