// Hands of a user on the panel: a mouse in the window's layout, a finger in the headset's.
#pragma once
#include <cmath>

#include "host/vr/headset_panel.h"
#include "tests/ui/panel_session.h"

namespace knead {

// Without OpenGL; null in a build without panels.
inline std::unique_ptr<PanelDrawing> open_layout(PanelDrawingOptions by)
{
    by.gl = false;
    return PanelDrawing::open(by);
}

class PanelDriver {
  public:
    explicit PanelDriver(PanelSession& of) : session(of) {}
    virtual ~PanelDriver() = default;
    // A press on a button or switch, long enough for one that must be held.
    virtual void press(ControlId id, int item = -1) = 0;
    // A slider, dragged from its middle to a share of its width.
    virtual void slide(ControlId id, float share) = 0;
    virtual void choose(ControlId id, int item) = 0;
    virtual void choose_object(int place) = 0;
    virtual void open(const std::string& file) = 0;

  protected:
    void apply(const std::vector<ControlEvent>& events)
    {
        for (const ControlEvent& one : events) session.panel.apply(one, session.live);
        if (!events.empty()) session.settle();
    }
    PanelSession& session;
};

class MouseDriver : public PanelDriver {
  public:
    static constexpr int width = 1000, height = 2400;  // all controls are visible
    explicit MouseDriver(PanelSession& of) : PanelDriver(of), drawing(open_layout({}))
    {
        for (int i = 0; i < 5; ++i) frame(0, 0, false);
    }
    void press(ControlId id, int item = -1) override
    {
        const PanelRect at = place(id, item);
        const float x = at.x + 0.5f * at.width, y = at.y + 0.5f * at.height;
        frame(x, y, false), frame(x, y, true), frame(x, y, false), frame(0, 0, false);
    }
    void slide(ControlId id, float share) override
    {
        const PanelRect at = place(id, -1);
        const float y = at.y + 0.5f * at.height;
        const float from = at.x + 0.5f * at.width, to = at.x + share * at.width;
        frame(from, y, false), frame(from, y, true);
        for (int k = 1; k <= 5; ++k) frame(from + (to - from) * float(k) / 5, y, true);
        frame(to, y, false), frame(0, 0, false);
    }
    void choose(ControlId id, int item) override { press(id), press(id, item); }
    void choose_object(int number) override
    {
        press({Control::object,
               int(session.live.state()->document->objects.at(std::size_t(number))->id.value)});
    }
    void open(const std::string& file) override
    {
        drawing->begin(Control::open);
        for (int i = 0; i < 4; ++i) frame(0, 0, false);
        type(file);
        press({Control::open, 0}, -2);
    }
    void type(const std::string& text)
    {
        PanelInput input;
        // UTF-8 of one and two bytes.
        for (std::size_t i = 0; i < text.size(); ++i) {
            const int byte = (unsigned char)text[i];
            if (byte < 0x80)
                input.typed.push_back(byte);
            else
                input.typed.push_back((byte & 0x1f) << 6 | (text.at(++i) & 0x3f));
        }
        send(input);
        frame(0, 0, false);
    }
    void key(PanelKey which)
    {
        PanelInput input;
        input.keys[std::size_t(which)] = true;
        send(input);
        frame(0, 0, false);
    }
    void frame(float x, float y, bool down)
    {
        PanelInput input;
        input.pointer = true, input.x = x, input.y = y, input.down[0] = down;
        send(input);
    }

    std::unique_ptr<PanelDrawing> drawing;

  private:
    PanelRect place(ControlId id, int item)
    {
        const auto at = drawing->place_of(id, item);
        if (at) return *at;
        ADD_FAILURE() << row_of(id.control).name << " " << id.index << ", item " << item
                      << " is not laid out in the window";
        return {};
    }
    void send(const PanelInput& input)
    {
        session.panel.refresh(*session.live.state());
        apply(drawing->frame(session.panel.model(), times, input, width, height));
    }
    TimeGraph times;
};

class FingerDriver : public PanelDriver {
  public:
    explicit FingerDriver(PanelSession& of, Workplace at = {})
        : PanelDriver(of), panel(of.panel), workplace(at)
    {
        const auto state = of.live.state();
        panel.place(workplace, clay_box(*state), live_hands(state->scene->scene));
        drawing = open_layout(HeadsetPanel::layout(panel.distance()));
        panel.set_drawing(drawing.get());
        for (int i = 0; i < 5; ++i) frame({}, false);
    }
    // The part of the panel that has the control.
    void show(Control control)
    {
        if (shown == int(row_of(control).part)) return;
        shown = int(row_of(control).part);
        poke(place({Control::panels, shown}, -1), 0.5f, 0.5f, 0.1);
    }
    void press(ControlId id, int item = -1) override
    {
        show(id.control);
        const bool held = row_of(id.control).discards;
        const PanelRect at = place(id, item);
        poke(at, 0.5f, 0.5f, held ? PanelDrawing::held_for + 0.3 : 0.1);
    }
    void slide(ControlId id, float share) override
    {
        show(id.control);
        poke(place(id, -1), 0.5f, share, 0.3);
    }
    void choose(ControlId id, int item) override { press(id), press(id, item); }
    void choose_object(int number) override { choose({Control::object, 0}, number); }
    void open(const std::string& file) override
    {
        const std::vector<std::string> files = session.panel.model().files;
        const auto at = std::find(files.begin(), files.end(), file);
        ASSERT_NE(at, files.end()) << file;
        choose({Control::open, 1}, int(at - files.begin()));
        press({Control::open, 0});
    }
    // A finger that comes to a place of the control, from its share `from` of the width to `to`,
    // and leaves after `seconds`.
    void poke(const PanelRect& at, float from, float to, double seconds)
    {
        const auto point = [&](float share, float z) {
            const TouchPanel& on = panel.shown().at(0);
            const float x = at.x + share * at.width, y = at.y + 0.5f * at.height;
            const Vec3<float> place{HeadsetPanel::pixel * (x - 0.5f * on.picture_width),
                                    HeadsetPanel::pixel * (0.5f * on.picture_height - y), z};
            return on.pose.p + rotate(on.pose.q, place);
        };
        constexpr float front = 0.04f, behind = 0.002f;
        for (int k = 0; k <= 10; ++k)
            frame(point(from, front + (behind - front) * float(k) / 10), true);
        const int frames = std::max(2, int(std::lround(90 * seconds)));
        for (int k = 1; k <= frames; ++k)
            frame(point(from + (to - from) * float(k) / float(frames), behind), true);
        for (int k = 1; k <= 10; ++k)
            frame(point(to, behind + (front - behind) * float(k) / 10), true);
        frame({}, false);
    }
    void frame(Vec3<float> tip, bool tracked)
    {
        PanelSurroundings around;
        around.head = {0, 0.35f, 0.5f};
        Hand& hand = around.hands[right];
        hand.tracked = tracked;
        hand.valid.fill(tracked);
        // Any hand: only the tip of its index finger presses.
        hand.joints[index_tip].p = tip;
        moved(tip, tracked);
        session.panel.refresh(*session.live.state());
        apply(panel.frame(times, around, time += 1.0 / 90, 1.0 / 90));
    }

    HeadsetPanel panel;
    std::unique_ptr<PanelDrawing> drawing;
    std::function<void(Vec3<float> tip, bool tracked)> moved = [](Vec3<float>, bool) {};

  private:
    PanelRect place(ControlId id, int item)
    {
        const auto at = drawing->place_of(id, item);
        if (at) return *at;
        ADD_FAILURE() << row_of(id.control).name << " " << id.index << ", item " << item
                      << " is not laid out in the headset";
        return {};
    }
    Workplace workplace;
    TimeGraph times;
    double time = 0;
    int shown = 1;
};

}  // namespace knead
