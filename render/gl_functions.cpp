#include "render/gl_functions.h"

namespace knead {

bool load_gl_functions(void (*(*address)(const char* name))())
{
    for (GlEntry* entry = GlEntry::first_; entry; entry = entry->next_) {
        entry->function_ = address(entry->name_);
        if (!entry->function_) return false;
    }
    GLint major = 0, minor = 0;  // stay 0 before OpenGL 3
    glGetIntegerv(GL_MAJOR_VERSION, &major);
    glGetIntegerv(GL_MINOR_VERSION, &minor);
    return major > 4 || (major == 4 && minor >= 5);
}

}  // namespace knead
