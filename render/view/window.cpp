#include "render/view/window.h"

#include <backends/imgui_impl_opengl3.h>
#include <dlfcn.h>
#include <imgui.h>

#include <algorithm>
#include <map>
#include <utility>

#include "host/base/errors.h"
#include "render/eye_painter.h"
#include "render/gl.h"
#include "render/view/glfw.h"
#include "render/view/panels.h"

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
    find(library, g.should_close, "glfwWindowShouldClose");
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
    if (!g.init()) throw ResourceError("no window: " + last_error(g));
    return g;
}

// Data written by the GLFW callbacks.
struct WindowInput {
    std::vector<InputEvent> events;
    double scale = 1;     // framebuffer pixels per window unit
    bool damaged = true;  // must be redrawn
};
WindowInput& input_of(GLFWwindow* window)
{
    return *static_cast<WindowInput*>(glfw().user(window));
}

// GLFW numbers keys by their place on a US keyboard. Letters: those of the user's layout.
int letter_of(int key, int scancode)
{
    if (key < 'A' || key > 'Z') return key;
    const char* name = glfw().key_name(key, scancode);
    const bool letter = name && name[0] >= 'a' && name[0] <= 'z' && name[1] == 0;
    return letter ? name[0] - 'a' + 'A' : key;
}

void install_callbacks(const Glfw& g, GLFWwindow* window)
{
    g.on_key(window, [](GLFWwindow* w, int key, int scancode, int action, int) {
        if (action == GLFW_REPEAT) return;
        InputEvent e{InputEvent::key};
        e.code = letter_of(key, scancode), e.down = action == GLFW_PRESS;
        input_of(w).events.push_back(e);
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
}

class GlfwWindow final : public Window {
  public:
    GlfwWindow(const std::string& title, int width, int height);
    ~GlfwWindow() override;
    int width() const override { return width_; }
    int height() const override { return height_; }
    bool closed() const override { return glfw().should_close(window_); }
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
    PanelRequests panels(PanelModel& model, const InputState& input, double seconds) override;
    int panels_width() const override { return hidden_; }
    bool mouse_taken() const override { return ImGui::GetIO().WantCaptureMouse; }
    bool keys_taken() const override { return ImGui::GetIO().WantTextInput; }
    void draw_panels() override;
    Image image() override;
    void show() override { glfw().swap(window_); }
    int gl_errors() override;
    bool lost() const override { return glGetGraphicsResetStatus() != GL_NO_ERROR; }

  private:
    void measure();
    unsigned texture_of(const std::shared_ptr<const Image>& picture);

    GLFWwindow* window_ = nullptr;
    WindowInput heard_;
    std::map<std::shared_ptr<const Image>, Texture> pictures_;  // on the panels
    int width_ = 0, height_ = 0, hidden_ = 0;
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
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // no imgui.ini file
    io.FontGlobalScale = float(std::max(1.0, heard_.scale));
    style_panels();
    if (!ImGui_ImplOpenGL3_Init("#version 450 core"))
        throw ResourceError("no window: the panels cannot be drawn with this OpenGL");
}

GlfwWindow::~GlfwWindow()
{
    pictures_.clear();
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext();
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

PanelRequests GlfwWindow::panels(PanelModel& model, const InputState& input, double seconds)
{
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {float(width_), float(height_)};
    io.DeltaTime = float(std::max(seconds, 1e-4));
    io.MousePos = {float(input.x()), float(input.y())};
    for (int b = 0; b < button_count; ++b)
        io.MouseDown[b] = input.held(MouseButton(b)) || input.clicked(MouseButton(b));
    io.MouseWheel = float(input.wheel());
    const std::pair<int, Key> keys[] = {
        {ImGuiKey_Tab, key_tab},          {ImGuiKey_Backspace, key_backspace},
        {ImGuiKey_Delete, key_delete},    {ImGuiKey_Enter, key_enter},
        {ImGuiKey_Escape, key_escape},    {ImGuiKey_LeftArrow, key_left},
        {ImGuiKey_RightArrow, key_right}, {ImGuiKey_Home, key_home},
        {ImGuiKey_End, key_end}};
    for (const auto& [theirs, ours] : keys) {
        io.KeyMap[theirs] = ours;
        io.KeysDown[ours] = input.held(ours) || input.pressed(ours);
    }
    io.KeyCtrl = input.control(), io.KeyShift = input.shift();
    for (const int letter : input.typed()) io.AddInputCharacter(unsigned(letter));
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    std::erase_if(pictures_, [](const auto& one) { return one.first.use_count() == 1; });
    const PanelRequests requests = build_panels(
        model, [this](const std::shared_ptr<const Image>& one) { return texture_of(one); });
    hidden_ = model.open ? int(panels_across()) : 0;
    ImGui::Render();
    return requests;
}

unsigned GlfwWindow::texture_of(const std::shared_ptr<const Image>& picture)
{
    Texture& made = pictures_[picture];
    if (made) return made;
    made = texture(GL_TEXTURE_2D);
    glTextureStorage2D(made, 1, GL_RGB8, picture->width, picture->height);
    glTextureParameteri(made, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage2D(made, 0, 0, 0, picture->width, picture->height, GL_RGB, GL_UNSIGNED_BYTE,
                        picture->rgb.data());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    return made;
}

void GlfwWindow::draw_panels()
{
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width_, height_);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
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
