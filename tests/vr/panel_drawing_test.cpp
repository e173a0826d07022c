// The panel as OpenGL draws it, off screen: in the window's layout and in the headset's. With
// KNEAD_GOLDEN_OUT=DIR the pictures are kept there, to be looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "host/ui/panel_refresh.h"
#include "tests/vr/panel_drivers.h"
#if KNEAD_HAS_GL
#include "render/context.h"
#include "render/draw_timer.h"
#include "render/gl.h"

namespace knead {
namespace {

class PanelDrawn : public testing::Test {
  protected:
    void SetUp() override
    {
        if (!open_layout({})) GTEST_SKIP() << no_panel;
        try {
            context = std::make_unique<Context>();
        } catch (const std::runtime_error& e) {
            GTEST_SKIP() << e.what();
        }
        bound = std::make_unique<Context::Bound>(*context);
    }

    // Of what was laid out last, on grey.
    Image drawn(PanelDrawing& panel, int width, int height)
    {
        Texture picture = texture(GL_TEXTURE_2D);
        glTextureStorage2D(picture, 1, GL_SRGB8_ALPHA8, width, height);
        Framebuffer target = framebuffer();
        glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, picture, 0);
        constexpr float grey[] = {0.5f, 0.5f, 0.5f, 1};
        glDisable(GL_FRAMEBUFFER_SRGB);
        glClearNamedFramebufferfv(target, GL_COLOR, 0, grey);
        panel.draw(target);
        std::vector<std::uint8_t> bytes(std::size_t(width) * std::size_t(height) * 3);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, target);
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        EXPECT_EQ(glGetError(), unsigned(GL_NO_ERROR));
        Image image{width, height, std::vector<std::uint8_t>(bytes.size())};
        const std::size_t row = std::size_t(3 * width);
        for (int y = 0; y < height; ++y)
            std::copy_n(bytes.begin() + std::ptrdiff_t(row) * (height - 1 - y), row,
                        image.rgb.begin() + std::ptrdiff_t(row) * y);
        return image;
    }
    void keep(const std::string& name, const Image& image)
    {
        if (const char* out = std::getenv("KNEAD_GOLDEN_OUT"))
            write_png(std::string(out) + "/" + name + ".png", image);
    }
    // Pixels within a rectangle that are nearly white: letters.
    static int white(const Image& image, const PanelRect& at)
    {
        int count = 0;
        for (int y = int(at.y); y < int(at.y + at.height); ++y)
            for (int x = int(at.x); x < int(at.x + at.width); ++x) {
                const std::uint8_t* p = &image.rgb[std::size_t(3 * (y * image.width + x))];
                count += p[0] > 200 && p[1] > 200 && p[2] > 200;
            }
        return count;
    }

    std::unique_ptr<Context> context;
    std::unique_ptr<Context::Bound> bound;
};

TEST_F(PanelDrawn, HasLettersOnItsControlsInEveryPartOfTheHeadset)
{
    PanelSession session(in_headset);
    for (const double g : {3.0, 5.0}) session.act(Control::gravity, g);
    FingerDriver finger(session);
    finger.drawing = PanelDrawing::open(HeadsetPanel::layout(finger.panel.distance()));
    finger.panel.set_drawing(finger.drawing.get());
    const int width = finger.drawing->picture_width(), height = finger.drawing->picture_height();
    for (int i = 0; i < 5; ++i) finger.frame({}, false);
    int controls = 0;
    for (const Control of :
         {Control::undo, Control::preset, Control::carry, Control::gravity, Control::quit}) {
        finger.show(of);
        for (int i = 0; i < 5; ++i) finger.frame({}, false);
        const Image image = drawn(*finger.drawing, width, height);
        keep(std::string("headset_") + row_of(of).name, image);
        for (const PanelSection& section : session.panel.model().sections)
            for (const ControlState& one : section.controls) {
                if (section.part != row_of(of).part) continue;
                const auto at = finger.drawing->place_of(one.id);
                if (!at) continue;
                EXPECT_GE(white(image, *at), one.why_not.empty() ? 20 : 0) << one.row().name;
                EXPECT_LE(at->y + at->height, float(HeadsetPanel::layout(1).height) + 0.5f)
                    << one.row().name << " is not in the panel";
                ++controls;
            }
        const auto undo = finger.drawing->place_of({Control::undo, 0}, PanelDrawing::on_palm_item);
        ASSERT_TRUE(undo);
        EXPECT_GE(undo->y, float(HeadsetPanel::layout(1).height));
        EXPECT_GT(white(image, *undo), 20);
    }
    EXPECT_GT(controls, 25);
}

// 900 x 600, the least window; a large one at scale 2.
TEST_F(PanelDrawn, FitsIntoWindowsOfAnySizeAndScale)
{
    PanelSession session(in_window);
    session.act(Control::gravity, 3.0);
    const struct {
        int width, height;
        float scale;
    } sizes[] = {{900, 600, 1}, {1600, 1000, 1}, {2560, 1440, 2}, {320, 240, 1}};
    for (const auto& size : sizes) {
        PanelDrawingOptions by;
        by.scale = size.scale;
        const auto panel = PanelDrawing::open(by);
        TimeGraph times;
        for (int i = 0; i < 40; ++i) times.add({{"solver", 0.003}, {"picture", 0.002}});
        for (int i = 0; i < 5; ++i)
            panel->frame(session.panel.model(), times, {}, size.width, size.height);
        keep("window_" + std::to_string(size.width), drawn(*panel, size.width, size.height));
        EXPECT_NEAR(panel->capital(), 9 * size.scale + 1, 1.5 * size.scale);
        EXPECT_GT(panel->covered(), 250 * size.scale);
        EXPECT_LT(panel->covered(), 320 * size.scale);
        const auto undo = panel->place_of({Control::undo, 0});
        ASSERT_TRUE(undo);
        EXPECT_LT(undo->x + undo->width, size.width);
        EXPECT_LT(undo->y + undo->height, size.height);
    }
}

// As window and headset draw it: laid out when something has changed, here in every tenth frame of
// 400. A graphics card has to keep what a frame with a layout may cost: 0.2 ms in the window, 0.3
// ms in the headset with its mipmaps.
TEST_F(PanelDrawn, TakesLittleOfAFrame)
{
    const auto median = [](std::vector<double> all) {
        if (all.empty()) return 0.0;
        std::nth_element(all.begin(), all.begin() + std::ptrdiff_t(all.size() / 2), all.end());
        return all[all.size() / 2];
    };
    const auto seconds_since = [](std::chrono::steady_clock::time_point begin) {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const bool card = context->name().find("NVIDIA") != std::string::npos;
    constexpr int frames = 400;
    for (const unsigned place : {unsigned(in_window), unsigned(in_headset)}) {
        PanelSession session(place);
        const bool window = place == in_window;
        const auto panel =
            PanelDrawing::open(window ? PanelDrawingOptions{} : HeadsetPanel::layout(0.6f));
        const int width = window ? 1600 : panel->picture_width(),
                  height = window ? 1000 : panel->picture_height();
        Texture picture = texture(GL_TEXTURE_2D);
        glTextureStorage2D(picture, window ? 1 : 4, GL_SRGB8_ALPHA8, width, height);
        Framebuffer target = framebuffer();
        glNamedFramebufferTexture(target, GL_COLOR_ATTACHMENT0, picture, 0);
        TimeGraph times;
        DrawTimer timer;
        PanelRefresh refresh;
        std::vector<double> laid_out, called, drawn;
        double all = 0;
        for (int i = 0; i < frames; ++i) {
            const auto begin = std::chrono::steady_clock::now();
            session.panel.refresh(*session.live.state());
            const bool due = refresh.due(session.panel.model(), i % 10 == 0, *panel, 1.0 / 90);
            if (due) panel->frame(session.panel.model(), times, {}, width, height);
            const double layout = seconds_since(begin);
            if (due) laid_out.push_back(layout);
            double calls = 0;
            if (window || due) {  // the headset keeps the picture
                const auto drawing = std::chrono::steady_clock::now();
                timer.begin(1);
                panel->draw(target);
                if (!window) glGenerateTextureMipmap(picture);
                timer.end();
                calls = seconds_since(drawing);
                called.push_back(calls);
                glFinish();
                while (const auto reading = timer.poll()) drawn.push_back(reading->seconds);
            }
            all += layout + calls;
        }
        const double layout = median(laid_out), calls = median(called), gpu = median(drawn);
        std::printf(
            "%s: a frame takes %.3f ms; when laid out model and layout take %.3f ms; calls of "
            "OpenGL %.3f ms, drawing %.3f ms on %s\n",
            window ? "window" : "headset", 1e3 * all / frames, 1e3 * layout, 1e3 * calls, 1e3 * gpu,
            context->name().c_str());
        EXPECT_LT(layout, 5e-3);
        EXPECT_GT(laid_out.size(), std::size_t(frames / 10));
        EXPECT_LT(laid_out.size(), std::size_t(frames / 2));
        EXPECT_GT(drawn.size(), window ? 200u : 50u);
        if (card) {
            EXPECT_LT(layout + std::max(calls, gpu), window ? 0.2e-3 : 0.3e-3);
        }
    }
}

}  // namespace
}  // namespace knead
#endif
