// The application's GL context, as it was given with the session.
#pragma once
#include <memory>

namespace knead::replay {

// Makes the session's context current while it lives, and puts back what was current before.
class GlGuard {
  public:
    virtual ~GlGuard() = default;
};

class GlGuardSource {
  public:
    virtual ~GlGuardSource() = default;
    virtual std::unique_ptr<GlGuard> bind() = 0;
    // Leaves no context current, as some runtimes do.
    virtual void steal() = 0;
    virtual const char* name() const = 0;
    virtual void* address(const char* function) const = 0;  // of OpenGL
};

// Of a graphics binding in the chain of XrSessionCreateInfo; null where there is none that is
// known. Loads the GL functions. Throws Refusal for a binding that cannot be used.
std::unique_ptr<GlGuardSource> gl_of(const void* chain);

}  // namespace knead::replay
