#include "host/vr/headset_objects.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/ui/panel_commands.h"
#include "host/ui/session_line.h"

namespace knead {
namespace {

constexpr double touch_reach = 0.02;  // of a touch [m of the hands]
constexpr double ray_range = 5;       // [m of the hands]
constexpr double line = 0.0015;       // width of marks [m of the hands]
constexpr double ray_line = 0.0008;
constexpr double short_ray = 0.15;  // of a hand that points at nothing [m of the hands]
constexpr Vec3<float> ray_colour{0.5f, 0.6f, 0.7f}, ring_colour{0.1f, 0.6f, 1.5f};
// A preview of more vertices would be drawn too slowly: its boxes remain.
constexpr std::size_t most_vertices = 60000;

void leave_boxes(ObjectPreviews& preview)
{
    std::size_t count = 0;
    for (const ObjectPreview& one : preview.objects) count += one.mesh.vertices.size();
    constexpr std::size_t of_box = 24 * 8;  // vertices of box_corners()
    if (count <= most_vertices) return;
    std::erase_if(preview.objects,
                  [&](const ObjectPreview& one) { return one.mesh.vertices.size() != of_box; });
}

}  // namespace

Joint<double> HeadsetObjects::in_simulation(const HandAct& act, const HandsOptions& options) const
{
    return {act.at.q, options.at + options.zoom * act.at.p};
}

void HeadsetObjects::stop(LiveSession& session)
{
    if (nozzle_) end_nozzle(session, true);
    forget();
}

void HeadsetObjects::forget()
{
    grab_.stop();
    nozzle_.reset(), clogged_since_ = -1;
    place_.reset();
    moved_.clear(), preview_ = {}, coming_ = {};
    for (const Side side : {left, right}) hover_[side].clear();
    panel_.ui.pointing.clear();
}

void HeadsetObjects::frame(const LiveState& state, LiveSession& session, const ObjectHands& hands)
{
    const HandMode mode = panel_.ui.hand_mode;
    now_ = hands.now;
    if (!state.scene || !state.document || !panel_.ui.document) return;
    if (std::exchange(history_, state.history) != state.history) forget();
    for (const Side side : {left, right})
        acts_[side] = hands.acts[side], aside_[side] = hands.aside[side];
    watch_.follow(state, session, mode == HandMode::choose, hands.waits, hands.now,
                  5e-4 * hands.options.zoom);
    if (panel_.ui.placing)
        place(state, session, hands);
    else if (mode == HandMode::choose)
        choose(state, session, hands);
    else if (mode == HandMode::lay)
        lay(state, session, hands);
    // A hand that comes back must open first.
    for (const Side side : {left, right})
        pinched_[side] = acts_[side].pinches || !acts_[side].tracked;
    panel_.ui.pointing = text();
}

void HeadsetObjects::choose(const LiveState& state, LiveSession& session, const ObjectHands& hands)
{
    const double zoom = hands.options.zoom;
    GrabInput input;
    input.time = hands.now, input.scale = zoom;
    input.adds = panel_.ui.support, input.adds_always = panel_.ui.several;
    input.cancels = hands.cancels;
    input.chosen = selection(panel_.ui);
    for (const Side side : {left, right}) {
        const HandAct& act = acts_[side];
        GrabHand& hand = input.hands[side];
        hand.tracked = act.tracked;
        hand.at = in_simulation(act, hands.options);
        const bool held = grab_.holds(side);
        hand.pinches = act.pinches && (held || !aside_[side]);
        // What is below a hand stays so while it pinches.
        if (!act.tracked || act.fist || (aside_[side] && !held) || !watch_.places)
            hover_[side].clear();
        else if (!act.pinches || !pinched_[side])
            hover_[side].frame(*watch_.places, *state.document,
                               {hand.at.p, zoom * touch_reach, act.ray, zoom * ray_range});
        hand.hovers = hover_[side].now();
    }
    const GrabAnswer answer = grab_.frame(input);
    switch (answer.choice) {
        case GrabAnswer::unchanged:
            break;
        case GrabAnswer::none:
            panel_.apply({{Control::object, 0}, {}, 0}, session);
            break;
        case GrabAnswer::alone: {
            const bool several = std::exchange(panel_.ui.several, false);
            panel_.apply({{Control::object, int(answer.object.value)}, {}, 0}, session);
            panel_.ui.several = several;
            break;
        }
        default:
            panel_.apply(
                {{Control::object, int(answer.object.value)}, answer.choice == GrabAnswer::more, 0},
                session);
    }
    if (answer.begins) begin_move(state, session, hands);
    if (answer.ends) end_move(state, session);
    if (answer.cancelled) panel_.note("The move was cancelled.");
    if (answer.cancelled || answer.ends) moved_.clear(), preview_ = {}, coming_ = {};
    if (coming_.valid() && coming_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
        preview_ = coming_.get();
}

void HeadsetObjects::place(const LiveState& state, LiveSession& session, const ObjectHands& hands)
{
    if (!place_) place_.emplace();
    PlaceGesture::Input input;
    for (const Side side : {left, right}) {
        const HandAct& act = acts_[side];
        input.hands[side] = {
            act.tracked && !aside_[side], act.pinches, in_simulation(act, hands.options), {}};
    }
    input.cancels = hands.cancels, input.snaps = panel_.ui.snaps;
    input.usual = panel_.ui.support == left ? right : left;
    const PlaceGesture::Answer answer = place_->frame(input);
    if (answer == PlaceGesture::goes_on) return;
    if (answer == PlaceGesture::placed)
        panel_.send(AddObject{placed(*panel_.ui.placing, *place_->at(), state.scene->scene.origin)},
                    session);
    place_.reset(), panel_.ui.placing.reset();
    panel_.ui.notice.clear();
}

void HeadsetObjects::begin_move(const LiveState& state, LiveSession& session,
                                const ObjectHands& hands)
{
    moved_ = selection(panel_.ui);
    std::string why = why_not_moved(state, panel_.ui.document, moved_);
    if (why.empty() && hands.waits) watch_.find(session, hands.now);
    CommonPlace common;
    if (watch_.places) common = common_place(*watch_.places, moved_);
    if (why.empty() && !common.any()) why = "The chosen object has no clay.";
    if (!why.empty()) {
        grab_.stop();
        moved_.clear();
        return panel_.note(why);
    }
    centre_ = common.centre;
    // Parting a large surface takes longer than a frame.
    const auto make = [surfaces = meshes_of(state), document = state.document,
                       places = watch_.places, objects = moved_,
                       thick = line * hands.options.zoom] {
        ObjectPreviews made = object_previews(*surfaces, *document, *places, objects, thick);
        leave_boxes(made);
        return made;
    };
    preview_ = {};
    if (hands.waits)
        preview_ = make();
    else
        coming_ = std::async(std::launch::async, make);
}

ObjectMotion HeadsetObjects::motion() const
{
    return object_motion(grab_.motion(), centre_, panel_.ui.snaps);
}

// One step of undo.
void HeadsetObjects::end_move(const LiveState& state, LiveSession& session)
{
    if (moved_.empty()) return;
    ++motions_;
    for (Command& command : motion().commands(moved_, state.scene->scene.origin)) {
        if (const std::string why = why_not(command, state); !why.empty()) return panel_.note(why);
        panel_.send(std::move(command), session, motions_);
    }
}

void HeadsetObjects::end_nozzle(LiveSession& session, bool keeps)
{
    panel_.send(nozzle_->end(), session);
    nozzle_.reset();
    clogged_since_ = -1;
    if (!keeps) panel_.apply({{Control::undo, 0}, {}, 0}, session);
}

// One strand at a time, from the pinch to its release. A hand that is lost ends it.
void HeadsetObjects::lay(const LiveState& state, LiveSession& session, const ObjectHands& hands)
{
    const auto at = [&](const HandAct& act) {
        const bool ring = panel_.ui.ring && act.ring;
        return hands.options.at + hands.options.zoom * (ring ? act.ring->centre : act.at.p);
    };
    if (nozzle_) {
        const HandAct& act = acts_[nozzle_side_];
        if (hands.cancels) return end_nozzle(session, false);
        if (!clogged(state, *nozzle_)) {
            clogged_since_ = -1;
        } else if (clogged_since_ < 0) {
            clogged_since_ = hands.now;
            panel_.note(clogged_notice);
        }
        if (act.tracked && act.pinches)
            if (auto moves = nozzle_->move_to(at(act))) panel_.send(std::move(*moves), session);
        if (!act.tracked || !act.pinches) end_nozzle(session, true);
        return;
    }
    for (const Side side : {left, right}) {
        const HandAct& act = acts_[side];
        if (!act.tracked || !act.pinches || pinched_[side] || aside_[side]) continue;
        std::optional<double> ring;
        if (act.ring) ring = hands.options.zoom * act.ring->diameter;
        NozzleGesture next(nozzle_tool(panel_.ui, ring), at(act), state.scene->scene.origin);
        if (const std::string why = why_not(next.begin(), state); !why.empty())
            return panel_.note(why);
        nozzle_ = std::move(next), nozzle_side_ = side;
        panel_.send(nozzle_->begin(), session);
        return;
    }
}

float HeadsetObjects::vibration(Side side) const
{
    constexpr double pulses = 4;  // [1/s]
    constexpr float strength = 0.6f;
    if (clogged_since_ < 0 || side != nozzle_side_) return 0;
    return std::fmod(pulses * (now_ - clogged_since_), 1.0) < 0.5 ? strength : 0;
}

std::string HeadsetObjects::text() const
{
    return grab_.moves() && !moved_.empty() ? motion().text() : std::string();
}

HandLook HeadsetObjects::nozzle_ring(Side side, const HandsOptions& options) const
{
    constexpr int pieces = 24;
    const HandAct& act = acts_[side];
    const bool ring = panel_.ui.ring && act.ring;
    const Vec3<double> axis = ring ? act.ring->axis : act.ray;
    const double radius =
        nozzle_tool(panel_.ui,
                    ring ? std::optional(options.zoom * act.ring->diameter) : std::nullopt)
            .diameter /
        2;
    const Vec3<double> centre = options.at + options.zoom * (ring ? act.ring->centre : act.at.p),
                       u = orthogonal(axis), v = cross(axis, u);
    const auto at = [&](int i) {
        const double angle = 2 * std::numbers::pi * i / pieces;
        return centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
    };
    Mesh mesh;
    for (int i = 0; i < pieces; ++i) add_line(mesh, at(i), at(i + 1), line * options.zoom);
    return mark_look(std::move(mesh), ring_colour);
}

std::vector<HandLook> HeadsetObjects::looks(const LiveState& state,
                                            const HandsOptions& options) const
{
    std::vector<HandLook> all;
    const UiState& ui = panel_.ui;
    if (!state.document || !ui.document) return all;
    if (ui.placing) {
        if (place_ && place_->at())
            all.push_back(mark_look(object_outline(*ui.placing, *place_->at(), line * options.zoom),
                                    chosen_colour));
        return all;
    }
    if (ui.hand_mode == HandMode::lay) {
        for (const Side side : {left, right})
            if (acts_[side].tracked && !acts_[side].fist && !aside_[side] &&
                (!nozzle_ || nozzle_side_ == side))
                all.push_back(nozzle_ring(side, options));
        return all;
    }
    if (ui.hand_mode != HandMode::choose) return all;
    if (grab_.moves() && !moved_.empty()) {
        const ObjectMotion now = motion();
        const auto at = [&](Vec3<double> x, Vec3<double> own) { return now.at(x, own); };
        for (const ObjectPreview& one : preview_.objects)
            all.push_back(preview_look(one, at, now.turn));
        return all;
    }
    const auto corners = [&](ObjectId id, Vec3<float> colour) {
        const SceneObject* const o = state.document->find(id);
        const Box3<double>* const box = watch_.box(id);
        if (!o || o->hidden || !box) return;
        all.push_back(mark_look(box_corners(*box, line * options.zoom), colour));
    };
    const std::vector<ObjectId> chosen = selection(ui);
    for (const ObjectId id : chosen) corners(id, chosen_colour);
    ObjectId marked;
    for (const Side side : {left, right}) {
        const HandAct& act = acts_[side];
        const auto& hovered = hover_[side].now();
        if (hovered && hovered->object != marked && !std::ranges::count(chosen, hovered->object))
            corners(marked = hovered->object, hovered_colour);
        if (!act.tracked || act.fist || aside_[side] || (hovered && hovered->touched)) continue;
        const Vec3<double> from = in_simulation(act, options).p;
        Mesh ray;
        add_line(ray, from, hovered ? hovered->point : from + short_ray * options.zoom * act.ray,
                 ray_line * options.zoom);
        all.push_back(mark_look(std::move(ray), ray_colour, hovered ? 1.0f : 0.5f));
    }
    return all;
}

}  // namespace knead
