#include "host/vr/headset_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cuda/math/rotation.h"
#include "host/document/command_table.h"

namespace knead {
namespace {

constexpr float row_height = 16, gap = 2;
constexpr float away = 0.012f;   // distance in front of the panel that ends a press [m]
constexpr float finest = 0.01f;  // least reported change of a slider
constexpr float deep = 0.06f;    // distance behind the panel beyond which a finger is ignored [m]
constexpr float slack = 0.01f;   // distance beside an item within which it is still held [m]
constexpr double hint = 2;       // duration of the hint that an item must be held [s]

constexpr PanelColour ground{30, 32, 38}, plain{62, 66, 76}, lit{96, 140, 96}, held{200, 150, 60},
    ink{238, 238, 232}, faint{150, 154, 160}, alarm{214, 84, 60};

PanelRect row(int number, float from, float to)  // shares of the width
{
    const float w = HeadsetPanel::width;
    return {w * from + gap, float(number) * row_height + gap, w * (to - from) - 2 * gap,
            row_height - gap};
}

std::string label_of(const PanelCommand& command, const PanelView& view)
{
    if (command.step < 0) return "<";
    if (command.step > 0) return ">";
    switch (command.act) {
        case PanelAct::stiffness:
            return "STIFFNESS";
        case PanelAct::yield:
            return view.yield < 0 ? "NO YIELD STRESS" : "YIELD STRESS";
        case PanelAct::gravity:
            return view.gravity ? "GRAVITY ON" : "GRAVITY OFF";
        case PanelAct::pause:
            return view.paused ? "GO ON" : "PAUSE";
        case PanelAct::reset:
            return "RESET";
        case PanelAct::recentre:
            return "RECENTRE";
        case PanelAct::posture:
            return view.standing ? "STANDING" : "SEATED";
        case PanelAct::side:
            return "OTHER SIDE";
        case PanelAct::hold:
            return view.carrying ? "SHAPE" : "HOLD";
        case PanelAct::undo:
            return Row<Undo>::row.label;
        case PanelAct::redo:
            return Row<Redo>::row.label;
        case PanelAct::save:
            return Row<Save>::row.label;
        case PanelAct::quit:
            return "QUIT";
        default:
            return "";
    }
}

// Text between the two arrows of a row.
std::string choice_of(PanelAct act, const PanelView& view)
{
    const auto tool = [](const std::string& name) { return name.empty() ? "BARE HAND" : name; };
    switch (act) {
        case PanelAct::scene:
            return view.scene;
        case PanelAct::material:
            return view.material;
        case PanelAct::left_tool:
            return "LEFT: " + tool(view.left_tool);
        case PanelAct::right_tool:
            return "RIGHT: " + tool(view.right_tool);
        case PanelAct::cells:
            return fmt::format("{} NODES", view.nodes);
        case PanelAct::surface:
            return fmt::format("SURFACE {} NODES", view.surface);
        default:
            return "";
    }
}

void centred(PanelCanvas& canvas, const PanelRect& rect, std::string text, PanelColour colour)
{
    const std::size_t most = std::size_t(std::max(1.0f, rect.width / letter_step));
    if (text.size() > most) text.resize(most);
    const float x = rect.x + 0.5f * (rect.width - float(letter_step * text.size() - 1));
    canvas.text(std::round(x), rect.y + std::floor(0.5f * (rect.height - letter_height)), text,
                colour);
}

// Breaks a text that is too long for one line into two, between words.
void centred_lines(PanelCanvas& canvas, const PanelRect& rect, const std::string& text,
                   PanelColour colour)
{
    const std::size_t most = std::size_t(rect.width / letter_step);
    if (text.size() <= most) return centred(canvas, rect, text, colour);
    const std::size_t space = text.rfind(' ', most);
    const bool between = space != std::string::npos && space > 0;
    PanelRect line = rect;
    line.y = rect.y - gap + 1, line.height = letter_height;
    centred(canvas, line, text.substr(0, between ? space : most), colour);
    line.y += letter_height + 1;
    centred(canvas, line, text.substr(between ? space + 1 : most), colour);
}

// Commands that lose the shaped clay; those that restart a scene do, too.
bool is_held(PanelAct act)
{
    return act == PanelAct::reset || act == PanelAct::quit || act == PanelAct::scene ||
           act == PanelAct::cells;
}

}  // namespace

HeadsetPanel::HeadsetPanel()
{
    int number = 1;
    const auto arrows = [&](PanelAct act) {
        all.push_back({row(number, 0, 0.14f), {act, -1, -1}, false, is_held(act)});
        all.push_back({row(number, 0.86f, 1), {act, 1, -1}, false, is_held(act)});
        ++number;
    };
    const auto slider = [&](PanelAct act) {
        all.push_back({row(number++, 0, 1), {act, 0, -1}, true});
    };
    const auto buttons = [&](std::initializer_list<PanelAct> acts) {
        float from = 0;
        const float each = 1 / float(acts.size());
        for (const PanelAct act : acts) {
            all.push_back({row(number, from, from + each), {act, 0, -1}, false, is_held(act)});
            from += each;
        }
        ++number;
    };
    arrows(PanelAct::scene), arrows(PanelAct::material);
    slider(PanelAct::stiffness), slider(PanelAct::yield);
    arrows(PanelAct::left_tool), arrows(PanelAct::right_tool), arrows(PanelAct::cells),
        arrows(PanelAct::surface);
    buttons({PanelAct::gravity, PanelAct::pause, PanelAct::side});
    buttons({PanelAct::undo, PanelAct::redo, PanelAct::save, PanelAct::hold});
    buttons({PanelAct::reset, PanelAct::recentre, PanelAct::posture, PanelAct::quit});
}

Joint<float> HeadsetPanel::pose(const Workplace& usual, Side side)
{
    const float across = side == left ? -0.30f : 0.30f;
    const Vec3<float> middle{across, 0.12f, 0.08f};
    const Vec3<float> head = -cast<float>(usual.at);
    Vec3<float> z = head - middle;
    // If the eyes are at the panel's centre, the direction is undefined.
    z = length(z) > 0.05f ? (1 / length(z)) * z : Vec3<float>{0, 0, 1};
    Vec3<float> x = cross(Vec3<float>{0, 1, 0}, z);
    x = length(x) > 0.05f ? (1 / length(x)) * x : Vec3<float>{1, 0, 0};
    return {quaternion(Mat3<float>{x, cross(z, x), z}), middle};
}

const PanelItem* HeadsetPanel::at(Vec3<float> tip) const
{
    const float x = tip.x / pixel + 0.5f * width, y = 0.5f * height - tip.y / pixel;
    for (const PanelItem& item : all)
        if (item.rect.holds(x, y)) return &item;
    return nullptr;
}

void HeadsetPanel::let_go(Finger& of)
{
    if (of.pressed && of.pressed->held && !of.done) left_early = of.pressed, left_at = now;
    of = {};
}

// A finger that slides off the item must come from the front again.
std::optional<PanelCommand> HeadsetPanel::hold(Finger& of, Vec3<float> tip)
{
    const float x = tip.x / pixel + 0.5f * width, y = 0.5f * height - tip.y / pixel;
    PanelRect around = of.pressed->rect;
    constexpr float more = slack / pixel;
    around.x -= more, around.y -= more, around.width += 2 * more, around.height += 2 * more;
    if (!around.holds(x, y)) return let_go(of), std::nullopt;
    if (of.done || now - of.since < held_for) return {};
    of.done = true;
    return of.pressed->command;
}

float HeadsetPanel::progress(const PanelItem& item) const
{
    float most = -1;
    for (const Finger& of : fingers)
        if (item.held && of.pressed == &item)
            most = std::max(most, of.done ? 1 : float((now - of.since) / held_for));
    return std::min(most, 1.f);
}

bool HeadsetPanel::moves() const
{
    const auto waits = [](const Finger& of) { return of.pressed && of.pressed->held && !of.done; };
    return waits(fingers[left]) || waits(fingers[right]) || now - left_at < hint;
}

std::optional<PanelCommand> HeadsetPanel::poke(Side side, Vec3<float> tip, bool tracked,
                                               double time)
{
    now = time;
    Finger& of = fingers[side];
    const float before = tip.z - finger;
    if (!tracked || !std::isfinite(tip.x + tip.y + tip.z) || before < -deep) {
        let_go(of);
        return {};
    }
    if (before > away) {
        let_go(of);
        of.armed = true;
        return {};
    }
    bool begins = false;
    if (of.armed && before <= 0) {
        of.armed = false;
        of.pressed = at(tip), of.since = time;
        of.press = ++presses;
        begins = true;
    }
    if (!of.pressed || (!begins && !of.pressed->slider && !of.pressed->held)) return {};
    if (of.pressed->held) return hold(of, tip);
    PanelCommand command = of.pressed->command;
    if (of.pressed->slider) {
        const float x = tip.x / pixel + 0.5f * width;
        command.value = clamp((x - of.pressed->rect.x) / of.pressed->rect.width, 0.f, 1.f);
        if (!begins && std::abs(command.value - of.value) < finest) return {};
        of.value = command.value;
        command.drag = of.press;
    }
    return command;
}

void HeadsetPanel::draw(PanelCanvas& canvas, const PanelView& view,
                        const FrameFigures& figures) const
{
    canvas.fill({0, 0, width, height}, ground);
    const PanelRect top = row(0, 0, 1);
    if (!view.failure.empty())
        centred_lines(canvas, top, "ENDED: " + view.failure, alarm);
    else if (!view.notice.empty())
        centred_lines(canvas, top, view.notice, ink);
    else
        centred(canvas, top, "KNEAD", faint);
    for (const PanelItem& item : all) draw_item(canvas, item, view);
    draw_graph(canvas, figures);
}

std::string HeadsetPanel::words_on(const PanelItem& item, const PanelView& view) const
{
    const float held_so_far = progress(item);
    const bool waits = held_so_far >= 0 && held_so_far < 1;
    const bool too_early = left_early == &item && now - left_at < hint;
    if (waits || too_early) return item.command.step == 0 ? "HOLD 1 S" : "HOLD";
    return label_of(item.command, view);
}

void HeadsetPanel::draw_item(PanelCanvas& canvas, const PanelItem& item,
                             const PanelView& view) const
{
    const bool down = fingers[left].pressed == &item || fingers[right].pressed == &item;
    const PanelAct act = item.command.act;
    const bool on = (act == PanelAct::gravity && view.gravity) ||
                    (act == PanelAct::pause && view.paused) ||
                    (act == PanelAct::hold && view.carrying);
    canvas.fill(item.rect, down && !item.held ? held : on ? lit : plain);
    PanelRect share = item.rect;
    share.width *= std::max(0.f, progress(item));
    canvas.fill(share, alarm);
    if (item.slider) {
        const float value = act == PanelAct::stiffness ? view.stiffness : view.yield;
        PanelRect done = item.rect;
        done.width *= clamp(value, 0.f, 1.f);
        canvas.fill(done, down ? held : lit);
    }
    const bool greyed = (act == PanelAct::undo && !view.no_undo.empty()) ||
                        (act == PanelAct::redo && !view.no_redo.empty()) ||
                        (act == PanelAct::save && !view.no_save.empty());
    if (greyed && !down) canvas.fill(item.rect, ground);
    centred(canvas, item.rect, words_on(item, view), greyed ? faint : ink);
    if (item.command.step < 0) {
        PanelRect between = item.rect;
        between.x += item.rect.width, between.width = width - 2 * between.x;
        centred(canvas, between, choice_of(act, view), ink);
    }
}

// Bars: work of each frame as a share of its period; line: limit of comfort.
void HeadsetPanel::draw_graph(PanelCanvas& canvas, const FrameFigures& figures) const
{
    const PanelRect box{gap, 12 * row_height + gap, width - 2 * gap, 2 * row_height - 2 * gap};
    canvas.fill(box, {18, 19, 22});
    const float step = box.width / float(FrameFigures::kept);
    const std::vector<FrameParts>& frames = figures.recent();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const float share = clamp(float(1 - frames[i].margin()), 0.f, 1.25f) / 1.25f;
        const float high = share * box.height;
        const bool late = frames[i].margin() < 0;
        canvas.fill({box.x + step * float(i), box.y + box.height - high, step, high},
                    late ? alarm : lit);
    }
    const float comfortable = box.height * (1 - 0.8f / 1.25f);
    canvas.fill({box.x, box.y + comfortable, box.width, 0.5f}, faint);
    std::string text =
        fmt::format("MARGIN {:.0f} %  {} LATE", 100 * figures.margin(), figures.missed());
    if (!frames.empty() && frames.back().scale < 1)
        text += fmt::format("  SIZE {:.0f} %", 100 * frames.back().scale);
    canvas.text(box.x + 3, box.y + 3, text, figures.is_comfortable() ? ink : alarm);
}

}  // namespace knead
