// Swapchains of GL textures, made in the application's context.
#include <algorithm>

#include "render/gl.h"
#include "tests/openxr_replay/runtime.h"

namespace knead::replay {
namespace {

constexpr int images = 3;
// Best first; what is a depth comes last.
const std::vector<std::int64_t> formats{GL_SRGB8_ALPHA8, GL_RGBA8, GL_RGBA16F,
                                        GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT16};

bool is_depth(std::int64_t format)
{
    return format == GL_DEPTH_COMPONENT32F || format == GL_DEPTH_COMPONENT16;
}

XrResult XRAPI_CALL list_formats(XrSession handle, std::uint32_t capacity, std::uint32_t* count,
                                 std::int64_t* to)
{
    return answered("xrEnumerateSwapchainFormats", [&](Runtime&) {
        session_of(handle);
        return give(formats, capacity, count, to);
    });
}

void check_info(const XrSwapchainCreateInfo& info)
{
    const bool known = std::find(formats.begin(), formats.end(), info.format) != formats.end();
    refuse_if(!known, XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "not among the formats");
    const XrSwapchainUsageFlags right_use = is_depth(info.format)
                                                ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                                : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    refuse_if((info.usageFlags & right_use) == 0, XR_ERROR_VALIDATION_FAILURE,
              "a use that its format is not for");
    refuse_if(info.createFlags & XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT,
              XR_ERROR_FEATURE_UNSUPPORTED, "content is not protected here");
    refuse_if(info.createFlags & ~XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT, XR_ERROR_VALIDATION_FAILURE,
              "not a swapchain's flags");
    refuse_if(info.width == 0 || info.height == 0 || info.width > 8192 || info.height > 8192 ||
                  info.arraySize == 0 || info.mipCount == 0 || info.sampleCount == 0 ||
                  (info.faceCount != 1 && info.faceCount != 6),
              XR_ERROR_VALIDATION_FAILURE, "a size that cannot be");
    refuse_if(
        info.sampleCount != 1 || info.faceCount != 1 || info.arraySize > 4 || info.mipCount != 1,
        XR_ERROR_FEATURE_UNSUPPORTED, "only plain textures and short arrays are here");
}

// Refuses where OpenGL has an error pending, or has not the memory.
void make_textures(const GlGuardSource& gl, SwapchainObject& chain, GLenum format)
{
    refuse_if(glGetError() != 0, XR_ERROR_RUNTIME_FAILURE, "called with a GL error pending");
    const auto count = GLsizei(chain.textures.size());
    const bool array = chain.layers > 1;
    glCreateTextures(array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, count, chain.textures.data());
    for (const unsigned texture : chain.textures)
        if (chain.memory.give(gl, texture, format, chain.width, chain.height, int(chain.layers)))
            ++runtime().imported;
        else if (array)
            glTextureStorage3D(texture, 1, format, chain.width, chain.height,
                               GLsizei(chain.layers));
        else
            glTextureStorage2D(texture, 1, format, chain.width, chain.height);
    refuse_if(glGetError() != 0, XR_ERROR_RUNTIME_FAILURE, "textures cannot be made");
}

XrResult XRAPI_CALL create(XrSession handle, const XrSwapchainCreateInfo* info, XrSwapchain* to)
{
    return answered("xrCreateSwapchain", [&](Runtime& r) {
        SessionObject& session = session_of(handle);
        check_struct(info, XR_TYPE_SWAPCHAIN_CREATE_INFO);
        check_info(*info);
        refuse_if(!to, XR_ERROR_VALIDATION_FAILURE, "no place for the handle");
        const bool once = (info->createFlags & XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT) != 0;
        const std::size_t count = once ? 1 : images;
        auto made = std::make_unique<SwapchainObject>(int(count));
        made->once = once;
        made->width = int(info->width), made->height = int(info->height);
        made->layers = info->arraySize;
        made->depth = is_depth(info->format);
        made->textures.resize(count), made->drawn.resize(count);
        {
            const auto held = session.gl->bind();
            make_textures(*session.gl, *made, GLenum(info->format));
        }
        if (r.context_stolen) session.gl->steal();
        *to = r.add<XrSwapchain>(std::move(made), number_of(handle));
    });
}

// Whether drawing that was released to the runtime is still under way.
bool is_drawn_into(const SwapchainObject& chain)
{
    return std::any_of(chain.drawn.begin(), chain.drawn.end(), [](void* drawn) {
        return drawn && glClientWaitSync(static_cast<GLsync>(drawn), 0, 0) == GL_TIMEOUT_EXPIRED;
    });
}

XrResult XRAPI_CALL destroy(XrSwapchain handle)
{
    return answered("xrDestroySwapchain", [&](Runtime& r) {
        SwapchainObject& chain = r.get<SwapchainObject>(handle);
        auto* session = dynamic_cast<SessionObject*>(r.objects.at(chain.parent).get());
        const auto held = session->gl->bind();
        complain_if(is_drawn_into(chain), "commands on its images have not finished");
        for (void* drawn : chain.drawn) glDeleteSync(static_cast<GLsync>(drawn));
        glDeleteTextures(GLsizei(chain.textures.size()), chain.textures.data());
        chain.memory.unmap();
        r.remove(number_of(handle));
    });
}

XrResult XRAPI_CALL list_images(XrSwapchain handle, std::uint32_t capacity, std::uint32_t* count,
                                XrSwapchainImageBaseHeader* to)
{
    return answered("xrEnumerateSwapchainImages", [&](Runtime& r) {
        const SwapchainObject& chain = r.get<SwapchainObject>(handle);
        auto* list = reinterpret_cast<XrSwapchainImageOpenGLKHR*>(to);
        std::vector<XrSwapchainImageOpenGLKHR> all;
        for (const unsigned texture : chain.textures)
            all.push_back({XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, nullptr, texture});
        for (std::uint32_t i = 0; list && i < capacity; ++i)
            check_struct(&list[i], XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR);
        return give(all, capacity, count, list);
    });
}

// A swapchain of a session that is not lost, with no GL error pending.
SwapchainObject& live(XrSwapchain handle)
{
    SwapchainObject& chain = runtime().get<SwapchainObject>(handle);
    SessionObject& session = session_of(reinterpret_cast<XrSession>(chain.parent));
    const auto held = session.gl->bind();
    refuse_if(glGetError() != 0, XR_ERROR_RUNTIME_FAILURE, "called with a GL error pending");
    return chain;
}

void steal_after(const SwapchainObject& chain)
{
    Runtime& r = runtime();
    if (r.context_stolen)
        dynamic_cast<SessionObject*>(r.objects.at(chain.parent).get())->gl->steal();
}

std::unique_ptr<GlGuard> bound(const SwapchainObject& chain)
{
    return session_of(reinterpret_cast<XrSession>(chain.parent)).gl->bind();
}

// As a compositor does, which shows an image when it has been drawn: an application that asks for
// more than OpenGL can draw waits here, and does not fill a queue without end.
void mark_drawing(SwapchainObject& chain)
{
    const auto held = bound(chain);
    void*& drawn = chain.drawn[std::size_t(chain.order.last_released())];
    glDeleteSync(static_cast<GLsync>(drawn));
    drawn = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
}
void wait_for_drawing(const SwapchainObject& chain)
{
    constexpr GLuint64 patience = 5'000'000'000;  // [ns]
    void* const drawn = chain.drawn[std::size_t(chain.order.last_waited())];
    if (!drawn) return;
    const auto held = bound(chain);
    const GLenum end =
        glClientWaitSync(static_cast<GLsync>(drawn), GL_SYNC_FLUSH_COMMANDS_BIT, patience);
    refuse_if(end != GL_ALREADY_SIGNALED && end != GL_CONDITION_SATISFIED, XR_ERROR_RUNTIME_FAILURE,
              "OpenGL does not end what it draws");
}

XrResult XRAPI_CALL acquire(XrSwapchain handle, const XrSwapchainImageAcquireInfo* info,
                            std::uint32_t* index)
{
    return answered("xrAcquireSwapchainImage", [&](Runtime&) {
        SwapchainObject& chain = live(handle);
        if (info) check_struct(info, XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
        refuse_if(!index, XR_ERROR_VALIDATION_FAILURE, "no place for the index");
        refuse_if(chain.once && chain.order.ever_acquired(), XR_ERROR_CALL_ORDER_INVALID,
                  "a static image, acquired before");
        int next = 0;
        allowed(chain.order.acquire(next));
        *index = std::uint32_t(next);
        steal_after(chain);
    });
}

XrResult XRAPI_CALL wait(XrSwapchain handle, const XrSwapchainImageWaitInfo* info)
{
    return answered("xrWaitSwapchainImage", [&](Runtime& r) -> XrResult {
        SwapchainObject& chain = live(handle);
        check_struct(info, XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
        const bool busy = r.script.has(FaultKind::busy_images, r.frame);
        refuse_if(busy && info->timeout == XR_INFINITE_DURATION, XR_ERROR_RUNTIME_FAILURE,
                  "an image that never comes free is waited for");
        if (busy) return XR_TIMEOUT_EXPIRED;
        allowed(chain.order.wait());
        wait_for_drawing(chain);
        steal_after(chain);
        return XR_SUCCESS;
    });
}

XrResult XRAPI_CALL release(XrSwapchain handle, const XrSwapchainImageReleaseInfo* info)
{
    return answered("xrReleaseSwapchainImage", [&](Runtime&) {
        SwapchainObject& chain = live(handle);
        if (info) check_struct(info, XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
        allowed(chain.order.release());
        mark_drawing(chain);
    });
}

}  // namespace

void add_swapchain_functions(Table& to)
{
    to["xrEnumerateSwapchainFormats"] = entry(list_formats);
    to["xrCreateSwapchain"] = entry(create);
    to["xrDestroySwapchain"] = entry(destroy);
    to["xrEnumerateSwapchainImages"] = entry(list_images);
    to["xrAcquireSwapchainImage"] = entry(acquire);
    to["xrWaitSwapchainImage"] = entry(wait);
    to["xrReleaseSwapchainImage"] = entry(release);
}

}  // namespace knead::replay
