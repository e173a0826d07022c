// Textures of memory that another process could have made, as those of runtimes with a compositor
// are: it is unmapped when they are destroyed, and whoever still draws into it faults.
#pragma once
#include <cstdint>
#include <vector>

#include "tests/openxr_replay/gl_guard.h"

namespace knead::replay {

class ImportedMemory {
  public:
    ImportedMemory() = default;
    ImportedMemory(const ImportedMemory&) = delete;

    // Gives a texture without storage `layers` layers (1: it is no array). False, with the texture
    // as it was, where this OpenGL takes no memory that is made here: anywhere but in Mesa's
    // software renderer. The context is current, as in all that follows.
    bool give(const GlGuardSource& gl, unsigned texture, unsigned format, int width, int height,
              int layers);
    // After the textures were deleted.
    void unmap();

  private:
    std::vector<unsigned> objects;
    void (*free)(int, const unsigned*) = nullptr;
};

}  // namespace knead::replay
