// An off-screen OpenGL 4.5 core context by EGL: on a device display (NVIDIA), Mesa's surfaceless
// platform, or its software renderer.
#pragma once
#include <memory>
#include <string>

namespace knead {

class Context {
  public:
    // Creates the context and loads the GL functions. Throws std::runtime_error that lists each
    // display tried and why it failed.
    Context();
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    // GL_RENDERER.
    const std::string& name() const { return name_; }

    // Makes the context current on this thread; the destructor restores the previous one.
    class Bound {
      public:
        explicit Bound(const Context& context);
        ~Bound();
        Bound(const Bound&) = delete;
        Bound& operator=(const Bound&) = delete;

      private:
        void *display_, *context_, *draw_, *read_;
        const Context& own_;
    };

  private:
    bool start(void* display, const std::string& way, std::string& reasons);

    void* display_ = nullptr;
    void* context_ = nullptr;
    std::string name_;
};

}  // namespace knead
