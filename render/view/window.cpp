#include "render/view/window.h"

#include <dlfcn.h>

#include <algorithm>
#include <cfloat>
#include <utility>

#include "host/base/errors.h"
#include "render/eye_painter.h"
#include "render/gl.h"
#include "render/view/glfw.h"

namespace knead {
namespace {

template <class Function>
void find(void* library, Function& function, const char* name)
{
    function = reinterpret_cast<Function>(::dlsym(library, name));
    if (!function) throw ResourceError(std::string("no window: libglfw.so.3 has no ") + name);
}

std::string last_error(const Glfw& g)
{
    const char* text = nullptr;
    return g.error(&text) != GLFW_NO_ERROR && text ? text : "no reason given";
}

Glfw load()
{
    void* library = ::dlopen("libglfw.so.3", RTLD_NOW | RTLD_LOCAL);
    if (!library)
        throw ResourceError("no window: GLFW (libglfw.so.3, in Debian libglfw3) is not installed");
    Glfw g{};
    find(library, g.init, "glfwInit");
    find(library, g.error, "glfwGetError");
    find(library, g.hint, "glfwWindowHint");
    find(library, g.create, "glfwCreateWindow");
    find(library, g.destroy, "glfwDestroyWindow");
    find(library, g.make_current, "glfwMakeContextCurrent");
    find(library, g.address, "glfwGetProcAddress");
    find(library, g.swap_interval, "glfwSwapInterval");
    find(library, g.swap, "glfwSwapBuffers");
    find(library, g.poll, "glfwPollEvents");
    find(library, g.wait, "glfwWaitEventsTimeout");
    find(library, g.wake, "glfwPostEmptyEvent");
    find(library, g.attribute, "glfwGetWindowAttrib");
    find(library, g.set_should_close, "glfwSetWindowShouldClose");
    find(library, g.set_title, "glfwSetWindowTitle");
    find(library, g.content_scale, "glfwGetWindowContentScale");
    find(library, g.clipboard, "glfwGetClipboardString");
    find(library, g.set_clipboard, "glfwSetClipboardString");
    find(library, g.framebuffer_size, "glfwGetFramebufferSize");
    find(library, g.window_size, "glfwGetWindowSize");
    find(library, g.set_user, "glfwSetWindowUserPointer");
    find(library, g.user, "glfwGetWindowUserPointer");
    find(library, g.key_name, "glfwGetKeyName");
    find(library, g.on_key, "glfwSetKeyCallback");
    find(library, g.on_text, "glfwSetCharCallback");
    find(library, g.on_move, "glfwSetCursorPosCallback");
    find(library, g.on_button, "glfwSetMouseButtonCallback");
    find(library, g.on_wheel, "glfwSetScrollCallback");
    find(library, g.on_refresh, "glfwSetWindowRefreshCallback");
    find(library, g.on_size, "glfwSetFramebufferSizeCallback");
    find(library, g.on_iconify, "glfwSetWindowIconifyCallback");
    find(library, g.on_content_scale, "glfwSetWindowContentScaleCallback");
    find(library, g.on_close, "glfwSetWindowCloseCallback");
    find(library, g.on_focus, "glfwSetWindowFocusCallback");
    find(library, g.on_enter, "glfwSetCursorEnterCallback");
    find(library, g.on_drop, "glfwSetDropCallback");
    if (!g.init()) throw ResourceError("no window: " + last_error(g));
    return g;
}

// Data written by the GLFW callbacks.
struct WindowInput {
    std::vector<InputEvent> events;
    KeyCodes keys;
    double scale = 1;     // framebuffer pixels per window unit
    bool damaged = true;  // must be redrawn
};
WindowInput& input_of(GLFWwindow* window)
{
    return *static_cast<WindowInput*>(glfw().user(window));
}

void install_callbacks(const Glfw& g, GLFWwindow* window)
{
    g.on_key(window, [](GLFWwindow* w, int key, int scancode, int action, int) {
        if (action == GLFW_REPEAT) return;
        WindowInput& input = input_of(w);
        InputEvent e{InputEvent::key};
        e.down = action == GLFW_PRESS;
        const char* name = glfw().key_name(key, scancode);
        e.code = e.down ? input.keys.press(scancode, key, name)
                        : input.keys.release(scancode, key, name);
        input.events.push_back(e);
    });
    g.on_text(window, [](GLFWwindow* w, unsigned letter) {
        InputEvent e{InputEvent::text};
        e.code = int(letter);
        input_of(w).events.push_back(e);
    });
    g.on_move(window, [](GLFWwindow* w, double x, double y) {
        const double scale = input_of(w).scale;
        input_of(w).events.push_back({InputEvent::move, scale * x, scale * y});
    });
    g.on_button(window, [](GLFWwindow* w, int button, int action, int) {
        InputEvent e{InputEvent::button};
        e.code = button, e.down = action == GLFW_PRESS;
        input_of(w).events.push_back(e);
    });
    g.on_wheel(window, [](GLFWwindow* w, double x, double y) {
        input_of(w).events.push_back({InputEvent::wheel, x, y});
    });
    g.on_refresh(window, [](GLFWwindow* w) { input_of(w).damaged = true; });
    g.on_size(window, [](GLFWwindow* w, int, int) { input_of(w).damaged = true; });
    g.on_iconify(window, [](GLFWwindow* w, int) { input_of(w).damaged = true; });
    g.on_content_scale(window, [](GLFWwindow* w, float, float) { input_of(w).damaged = true; });
    g.on_close(window, [](GLFWwindow* w) {
        glfw().set_should_close(w, GLFW_FALSE);
        input_of(w).events.push_back({InputEvent::close});
    });
    g.on_focus(window, [](GLFWwindow* w, int focused) {
        if (focused) return;
        input_of(w).keys.clear();
        input_of(w).events.push_back({InputEvent::unfocus});
    });
    g.on_enter(window, [](GLFWwindow* w, int entered) {
        input_of(w).events.push_back({entered ? InputEvent::enter : InputEvent::leave});
    });
    g.on_drop(window, [](GLFWwindow* w, int count, const char** files) {
        for (int i = 0; i < count; ++i) {
            InputEvent e{InputEvent::drop};
            e.file = files[i];
            input_of(w).events.push_back(e);
        }
    });
}

class GlfwWindow final : public Window {
  public:
    GlfwWindow(const std::string& title, int width, int height);
    ~GlfwWindow() override;
    int width() const override { return width_; }
    int height() const override { return height_; }
    double content_scale() const override
    {
        float across = 1, down = 1;
        glfw().content_scale(window_, &across, &down);
        return across > 0 ? double(across) : 1;
    }
    void set_title(const std::string& text) override { glfw().set_title(window_, text.c_str()); }
    std::string clipboard() const override
    {
        const char* text = glfw().clipboard(window_);
        return text ? text : "";
    }
    void set_clipboard(const std::string& text) override
    {
        glfw().set_clipboard(window_, text.c_str());
    }
    std::string renderer() const override
    {
        const GLubyte* name = glGetString(GL_RENDERER);
        return name ? reinterpret_cast<const char*>(name) : "unnamed";
    }
    bool visible() const override
    {
        const Glfw& g = glfw();
        return g.attribute(window_, GLFW_VISIBLE) && !g.attribute(window_, GLFW_ICONIFIED);
    }
    std::vector<InputEvent> poll(double patience) override;
    bool damaged() override { return std::exchange(heard_.damaged, false); }
    Image image() override;
    void show() override { glfw().swap(window_); }
    int gl_errors() override;
    bool lost() const override { return glGetGraphicsResetStatus() != GL_NO_ERROR; }

  private:
    void measure();

    GLFWwindow* window_ = nullptr;
    WindowInput heard_;
    int width_ = 0, height_ = 0;
};

GlfwWindow::GlfwWindow(const std::string& title, int width, int height)
{
    const Glfw& g = glfw();
    g.hint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    g.hint(GLFW_CONTEXT_VERSION_MINOR, 5);
    g.hint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    g.hint(GLFW_SAMPLES, 0);
    g.hint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    window_ = g.create(width, height, title.c_str(), nullptr, nullptr);
    if (!window_) {  // not every driver supports robust contexts
        g.hint(GLFW_CONTEXT_ROBUSTNESS, GLFW_NO_ROBUSTNESS);
        window_ = g.create(width, height, title.c_str(), nullptr, nullptr);
    }
    if (!window_) throw ResourceError("no window with OpenGL 4.5: " + last_error(g));
    g.make_current(window_);
    try {
        load_gl(g.address);
    } catch (const std::runtime_error& e) {
        g.destroy(window_);
        throw ResourceError(e.what());
    }
    g.swap_interval(1);
    g.set_user(window_, &heard_);
    install_callbacks(g, window_);
    measure();
}

GlfwWindow::~GlfwWindow()
{
    glfw().make_current(nullptr);
    glfw().destroy(window_);
}

void GlfwWindow::measure()
{
    int across = 0, down = 0;
    glfw().framebuffer_size(window_, &width_, &height_);
    glfw().window_size(window_, &across, &down);
    heard_.scale = across > 0 && width_ > 0 ? double(width_) / across : 1;
}

std::vector<InputEvent> GlfwWindow::poll(double patience)
{
    if (patience > 0)
        glfw().wait(patience);
    else
        glfw().poll();
    measure();
    return std::exchange(heard_.events, {});
}

Image GlfwWindow::image()
{
    const std::size_t row = std::size_t(3) * std::size_t(width_);
    std::vector<std::uint8_t> upside_down(row * std::size_t(height_));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, upside_down.data());
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    Image image{width_, height_, std::vector<std::uint8_t>(upside_down.size())};
    for (int y = 0; y < height_; ++y)
        std::copy_n(upside_down.begin() + std::ptrdiff_t(row) * (height_ - 1 - y), row,
                    image.rgb.begin() + std::ptrdiff_t(row) * y);
    return image;
}

int GlfwWindow::gl_errors()
{
    int count = 0;
    for (; count < 100 && glGetError() != GL_NO_ERROR; ++count) {
    }
    return count;
}

}  // namespace

const Glfw& glfw()
{
    static const Glfw functions = load();
    return functions;
}

void Window::wake() { glfw().wake(); }

std::unique_ptr<Window> Window::open(const std::string& title, int width, int height)
{
    return std::make_unique<GlfwWindow>(title, width, height);
}

}  // namespace knead
