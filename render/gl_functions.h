// All OpenGL 4.5 functions called by this program; add a line for each new one. Include before
// GL/gl.h: after it, glcorearb.h does not declare the types of OpenGL 1.
#pragma once
#include <GL/glcorearb.h>

namespace knead {

// Every GlFunction is in one linked list, traversed by load_gl_functions().
class GlEntry {
  public:
    explicit GlEntry(const char* name) : name_(name), next_(first_) { first_ = this; }
    GlEntry(const GlEntry&) = delete;
    GlEntry& operator=(const GlEntry&) = delete;

  protected:
    void (*function_)() = nullptr;

  private:
    friend bool load_gl_functions(void (*(*)(const char*))());
    const char* name_;
    GlEntry* next_;
    inline static GlEntry* first_ = nullptr;
};

// One function, called by its OpenGL name; null until loaded.
template <class Pointer>
class GlFunction : GlEntry {
  public:
    using GlEntry::GlEntry;
    operator Pointer() const { return reinterpret_cast<Pointer>(function_); }
};

// Loads all functions for the current context by the platform's `address`. Returns false if one is
// missing or the context is below OpenGL 4.5.
bool load_gl_functions(void (*(*address)(const char* name))());

inline GlFunction<PFNGLATTACHSHADERPROC> glAttachShader{"glAttachShader"};
inline GlFunction<PFNGLBEGINQUERYPROC> glBeginQuery{"glBeginQuery"};
inline GlFunction<PFNGLBINDBUFFERPROC> glBindBuffer{"glBindBuffer"};
inline GlFunction<PFNGLBINDBUFFERBASEPROC> glBindBufferBase{"glBindBufferBase"};
inline GlFunction<PFNGLBINDFRAMEBUFFERPROC> glBindFramebuffer{"glBindFramebuffer"};
inline GlFunction<PFNGLBINDSAMPLERSPROC> glBindSamplers{"glBindSamplers"};
inline GlFunction<PFNGLBINDTEXTUREUNITPROC> glBindTextureUnit{"glBindTextureUnit"};
inline GlFunction<PFNGLBINDTEXTURESPROC> glBindTextures{"glBindTextures"};
inline GlFunction<PFNGLBINDVERTEXARRAYPROC> glBindVertexArray{"glBindVertexArray"};
inline GlFunction<PFNGLBLENDCOLORPROC> glBlendColor{"glBlendColor"};
inline GlFunction<PFNGLBLENDFUNCPROC> glBlendFunc{"glBlendFunc"};
inline GlFunction<PFNGLBLITNAMEDFRAMEBUFFERPROC> glBlitNamedFramebuffer{"glBlitNamedFramebuffer"};
inline GlFunction<PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC> glCheckNamedFramebufferStatus{
    "glCheckNamedFramebufferStatus"};
inline GlFunction<PFNGLCLEARNAMEDFRAMEBUFFERFVPROC> glClearNamedFramebufferfv{
    "glClearNamedFramebufferfv"};
inline GlFunction<PFNGLCLIENTWAITSYNCPROC> glClientWaitSync{"glClientWaitSync"};
inline GlFunction<PFNGLCLIPCONTROLPROC> glClipControl{"glClipControl"};
inline GlFunction<PFNGLCOLORMASKPROC> glColorMask{"glColorMask"};
inline GlFunction<PFNGLCOMPILESHADERPROC> glCompileShader{"glCompileShader"};
inline GlFunction<PFNGLCREATEBUFFERSPROC> glCreateBuffers{"glCreateBuffers"};
inline GlFunction<PFNGLCREATEFRAMEBUFFERSPROC> glCreateFramebuffers{"glCreateFramebuffers"};
inline GlFunction<PFNGLCREATEPROGRAMPROC> glCreateProgram{"glCreateProgram"};
inline GlFunction<PFNGLCREATEQUERIESPROC> glCreateQueries{"glCreateQueries"};
inline GlFunction<PFNGLCREATESHADERPROC> glCreateShader{"glCreateShader"};
inline GlFunction<PFNGLCREATETEXTURESPROC> glCreateTextures{"glCreateTextures"};
inline GlFunction<PFNGLCREATEVERTEXARRAYSPROC> glCreateVertexArrays{"glCreateVertexArrays"};
inline GlFunction<PFNGLCULLFACEPROC> glCullFace{"glCullFace"};
inline GlFunction<PFNGLDELETEBUFFERSPROC> glDeleteBuffers{"glDeleteBuffers"};
inline GlFunction<PFNGLDELETEFRAMEBUFFERSPROC> glDeleteFramebuffers{"glDeleteFramebuffers"};
inline GlFunction<PFNGLDELETEPROGRAMPROC> glDeleteProgram{"glDeleteProgram"};
inline GlFunction<PFNGLDELETEQUERIESPROC> glDeleteQueries{"glDeleteQueries"};
inline GlFunction<PFNGLDELETESHADERPROC> glDeleteShader{"glDeleteShader"};
inline GlFunction<PFNGLDELETESYNCPROC> glDeleteSync{"glDeleteSync"};
inline GlFunction<PFNGLDELETETEXTURESPROC> glDeleteTextures{"glDeleteTextures"};
inline GlFunction<PFNGLDELETEVERTEXARRAYSPROC> glDeleteVertexArrays{"glDeleteVertexArrays"};
inline GlFunction<PFNGLDEPTHFUNCPROC> glDepthFunc{"glDepthFunc"};
inline GlFunction<PFNGLDEPTHMASKPROC> glDepthMask{"glDepthMask"};
inline GlFunction<PFNGLDEPTHRANGEFPROC> glDepthRangef{"glDepthRangef"};
inline GlFunction<PFNGLDISABLEPROC> glDisable{"glDisable"};
inline GlFunction<PFNGLDRAWARRAYSPROC> glDrawArrays{"glDrawArrays"};
inline GlFunction<PFNGLDRAWELEMENTSPROC> glDrawElements{"glDrawElements"};
inline GlFunction<PFNGLDRAWELEMENTSINDIRECTPROC> glDrawElementsIndirect{"glDrawElementsIndirect"};
inline GlFunction<PFNGLENABLEPROC> glEnable{"glEnable"};
inline GlFunction<PFNGLENABLEVERTEXARRAYATTRIBPROC> glEnableVertexArrayAttrib{
    "glEnableVertexArrayAttrib"};
inline GlFunction<PFNGLENDQUERYPROC> glEndQuery{"glEndQuery"};
inline GlFunction<PFNGLFENCESYNCPROC> glFenceSync{"glFenceSync"};
inline GlFunction<PFNGLFINISHPROC> glFinish{"glFinish"};
inline GlFunction<PFNGLFLUSHPROC> glFlush{"glFlush"};
inline GlFunction<PFNGLFRONTFACEPROC> glFrontFace{"glFrontFace"};
inline GlFunction<PFNGLGENQUERIESPROC> glGenQueries{"glGenQueries"};
inline GlFunction<PFNGLGENERATETEXTUREMIPMAPPROC> glGenerateTextureMipmap{
    "glGenerateTextureMipmap"};
inline GlFunction<PFNGLGETERRORPROC> glGetError{"glGetError"};
inline GlFunction<PFNGLGETGRAPHICSRESETSTATUSPROC> glGetGraphicsResetStatus{
    "glGetGraphicsResetStatus"};
inline GlFunction<PFNGLGETINTEGERVPROC> glGetIntegerv{"glGetIntegerv"};
inline GlFunction<PFNGLGETPROGRAMINFOLOGPROC> glGetProgramInfoLog{"glGetProgramInfoLog"};
inline GlFunction<PFNGLGETPROGRAMIVPROC> glGetProgramiv{"glGetProgramiv"};
inline GlFunction<PFNGLGETQUERYOBJECTIVPROC> glGetQueryObjectiv{"glGetQueryObjectiv"};
inline GlFunction<PFNGLGETQUERYOBJECTUI64VPROC> glGetQueryObjectui64v{"glGetQueryObjectui64v"};
inline GlFunction<PFNGLGETSHADERINFOLOGPROC> glGetShaderInfoLog{"glGetShaderInfoLog"};
inline GlFunction<PFNGLGETSHADERIVPROC> glGetShaderiv{"glGetShaderiv"};
inline GlFunction<PFNGLGETSTRINGPROC> glGetString{"glGetString"};
inline GlFunction<PFNGLISENABLEDPROC> glIsEnabled{"glIsEnabled"};
inline GlFunction<PFNGLLINKPROGRAMPROC> glLinkProgram{"glLinkProgram"};
inline GlFunction<PFNGLNAMEDBUFFERDATAPROC> glNamedBufferData{"glNamedBufferData"};
inline GlFunction<PFNGLNAMEDBUFFERSTORAGEPROC> glNamedBufferStorage{"glNamedBufferStorage"};
inline GlFunction<PFNGLNAMEDBUFFERSUBDATAPROC> glNamedBufferSubData{"glNamedBufferSubData"};
inline GlFunction<PFNGLNAMEDFRAMEBUFFERDRAWBUFFERPROC> glNamedFramebufferDrawBuffer{
    "glNamedFramebufferDrawBuffer"};
inline GlFunction<PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC> glNamedFramebufferDrawBuffers{
    "glNamedFramebufferDrawBuffers"};
inline GlFunction<PFNGLNAMEDFRAMEBUFFERREADBUFFERPROC> glNamedFramebufferReadBuffer{
    "glNamedFramebufferReadBuffer"};
inline GlFunction<PFNGLNAMEDFRAMEBUFFERTEXTUREPROC> glNamedFramebufferTexture{
    "glNamedFramebufferTexture"};
inline GlFunction<PFNGLNAMEDFRAMEBUFFERTEXTURELAYERPROC> glNamedFramebufferTextureLayer{
    "glNamedFramebufferTextureLayer"};
inline GlFunction<PFNGLPIXELSTOREIPROC> glPixelStorei{"glPixelStorei"};
inline GlFunction<PFNGLPOLYGONMODEPROC> glPolygonMode{"glPolygonMode"};
inline GlFunction<PFNGLREADBUFFERPROC> glReadBuffer{"glReadBuffer"};
inline GlFunction<PFNGLREADPIXELSPROC> glReadPixels{"glReadPixels"};
inline GlFunction<PFNGLSCISSORPROC> glScissor{"glScissor"};
inline GlFunction<PFNGLSHADERSOURCEPROC> glShaderSource{"glShaderSource"};
inline GlFunction<PFNGLTEXTUREPARAMETERFVPROC> glTextureParameterfv{"glTextureParameterfv"};
inline GlFunction<PFNGLTEXTUREPARAMETERIPROC> glTextureParameteri{"glTextureParameteri"};
inline GlFunction<PFNGLTEXTURESTORAGE2DPROC> glTextureStorage2D{"glTextureStorage2D"};
inline GlFunction<PFNGLTEXTURESTORAGE2DMULTISAMPLEPROC> glTextureStorage2DMultisample{
    "glTextureStorage2DMultisample"};
inline GlFunction<PFNGLTEXTURESTORAGE3DPROC> glTextureStorage3D{"glTextureStorage3D"};
inline GlFunction<PFNGLTEXTURESUBIMAGE2DPROC> glTextureSubImage2D{"glTextureSubImage2D"};
inline GlFunction<PFNGLUNIFORM1FPROC> glUniform1f{"glUniform1f"};
inline GlFunction<PFNGLUNIFORM1IPROC> glUniform1i{"glUniform1i"};
inline GlFunction<PFNGLUNIFORM2FPROC> glUniform2f{"glUniform2f"};
inline GlFunction<PFNGLUNIFORM3FPROC> glUniform3f{"glUniform3f"};
inline GlFunction<PFNGLUNIFORM4FPROC> glUniform4f{"glUniform4f"};
inline GlFunction<PFNGLUNIFORM4FVPROC> glUniform4fv{"glUniform4fv"};
inline GlFunction<PFNGLUSEPROGRAMPROC> glUseProgram{"glUseProgram"};
inline GlFunction<PFNGLVERTEXARRAYATTRIBBINDINGPROC> glVertexArrayAttribBinding{
    "glVertexArrayAttribBinding"};
inline GlFunction<PFNGLVERTEXARRAYATTRIBFORMATPROC> glVertexArrayAttribFormat{
    "glVertexArrayAttribFormat"};
inline GlFunction<PFNGLVERTEXARRAYELEMENTBUFFERPROC> glVertexArrayElementBuffer{
    "glVertexArrayElementBuffer"};
inline GlFunction<PFNGLVERTEXARRAYVERTEXBUFFERPROC> glVertexArrayVertexBuffer{
    "glVertexArrayVertexBuffer"};
inline GlFunction<PFNGLVERTEXATTRIB4FPROC> glVertexAttrib4f{"glVertexAttrib4f"};
inline GlFunction<PFNGLVIEWPORTPROC> glViewport{"glViewport"};

}  // namespace knead
