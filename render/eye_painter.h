// Live pictures: clay, hands, floor and splats as an eye sees them, drawn with OpenGL 4.5 into a
// framebuffer of the caller, in the context that is current. A subset of Painter's light, made for
// every frame of a window or a headset.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "cuda/splats/eye.h"
#include "host/share/sharing.h"
#include "render/geometry.h"

namespace knead {

class DeviceGaussians;  // host/splats/device_gaussians.h
class DeviceMesh;       // host/surface/device_mesh.h
class GpuRaster;        // host/splats/gpu_raster.h
struct SplatFrame;

// Finds the functions of OpenGL for contexts that others have made current, e.g. GLFW or an OpenXR
// front end; Context (render/context.h) does it itself. Throws std::runtime_error for less than
// OpenGL 4.5.
using GlAddress = void (*(*)(const char* name))();
void load_gl(GlAddress address);

// Where an eye is and what it sees. Axes as in OpenXR: x right, y up, the gaze along -z.
struct EyeView {
    Vec3<float> position{};            // [m]
    Quat<float> rotation{1, 0, 0, 0};  // unit; of the axes
    float left = -1, right = 1, down = -1,
          up = 1;               // tangents of the sides: left < right, down < up
    float near = 0.01f;         // nothing nearer is drawn [m]
    int width = 0, height = 0;  // pixels
};
EyeView eye_view(const Camera& camera);
// The same eye for a rasteriser of splats, whose y goes down.
Eye<float> splat_eye(const EyeView& view);

// Into what is drawn.
struct EyeTarget {
    unsigned framebuffer = 0;  // GL name; 0: the window's
    int x = 0, y = 0;          // of the picture's lower left corner in it [pixels]
    // Its colours are of an sRGB format, or of a floating-point one: linear values are written, and
    // GL encodes them where the format asks for it. Otherwise sRGB is written.
    bool linear = false;
};

// How it is drawn.
struct EyeLook {
    float floor = 0;  // height of the ground [m]
    bool floor_seen = true;
    bool transparent = false;  // no backdrop: alpha is 0 where there is nothing
    int highlight = -1;        // category of clay that glows; -1: none
    // Clay is drawn where it is when it has gone on as it came, by so much of its way since the
    // meshes before (Mesh::advance).
    float extrapolation = 0;
    Vec3<float> light{-0.75f, 1, 0.45f};  // towards the key light, of any length
    Ball stage{{0.5f, 0.25f, 0.5f}, 1};   // about all that matters: clay outside casts no shadow
};

// What splats look like to an eye, from a rasteriser, rows from the top; of any resolution.
struct SplatLayer {
    int width = 0, height = 0;  // 0: none
    std::vector<float> colour;  // 4 a pixel: red, green, blue as displayed, times alpha; alpha
    std::vector<float> depth;   // along the gaze [m]; 1e30 or infinity: nothing is there
};

class EyePainter {
  public:
    // In the context that is current, whose functions have been found; it must be current whenever
    // the painter is used or deleted. `samples` a pixel, and twice as many lookups of a
    // shadow: 1, 2, 4 or 8; software renderers want 1. Throws std::runtime_error
    // with the reason where this OpenGL does not do. `share`: what a CUDA device makes may come
    // without a way through host memory, where that device draws.
    static std::unique_ptr<EyePainter> open(int samples = 4, bool share = true);
    virtual ~EyePainter() = default;

    // Whether it does so for this CUDA device, found out once.
    virtual const Sharing& sharing(int device) = 0;

    // Clay as meshed; uploaded where `version` is another than the last time. Clay of the
    // categories `unseen` only casts its shadow: splats are drawn where it is. Throws
    // std::invalid_argument for a mesh that cannot be drawn.
    virtual void set_clay(const std::vector<Mesh>& meshes, long version,
                          const std::vector<int>& unseen = {}) = 0;
    // The same of a mesh on a CUDA device: shared with it where that can be, else fetched. The host
    // waits for nothing where it is shared.
    virtual void set_device_clay(const DeviceMesh& mesh, long version,
                                 const std::vector<int>& unseen = {}) = 0;
    virtual void set_hands(const std::vector<HandLook>& hands) = 0;
    void set_hands(const std::vector<DrawPrimitive>& primitives)
    {
        set_hands(std::vector<HandLook>{{primitives, {}, 1, true}});
    }
    // Of eye 0 or 1, until they are set again. Throws std::invalid_argument for a layer whose
    // arrays do not belong together.
    virtual void set_splats(int eye, const SplatLayer& layer) = 0;
    // The same from textures of the caller's, with the layout of a SplatLayer (GL_RGBA of any
    // floating-point or normalised format; GL_R32F), e.g. written by CUDA. 0: none.
    virtual void set_splats(int eye, unsigned colour, unsigned depth) = 0;
    // What nobody sees of the pictures of eye 0 or 1, until it is set again: triangles, three
    // corners each, in tangents (x right, y up). There nothing is shaded, and the target gets no
    // colour, alpha 0 and the depth of what is infinitely far. Throws std::invalid_argument for
    // corners that are not finite, or not in threes.
    virtual void set_hidden(int eye, const std::vector<std::array<float, 2>>& corners) = 0;
    // What eyes 0 and 1, or 0 alone, see by a rasteriser on a CUDA device: all eyes of the frame,
    // one order of depth. The host waits for nothing. False, and nothing is done, where it cannot
    // be shared. The first splats are where `moved` says, if it is there, and not where the frame
    // does. Throws as GpuRaster::launch().
    virtual bool set_splats(GpuRaster& raster, const SplatFrame& frame,
                            const DeviceGaussians* moved = nullptr) = 0;
    // Such pictures of up to so many pixels are to come: none of them waits for other textures.
    virtual void expect_splats(int width, int height) = 0;
    // What such pictures take on the device lately [s]; 0: none is known.
    virtual double splat_seconds() const = 0;

    // Draws all that was set, of `eye` 0 or 1 the splats. Of the framebuffer's viewport nothing is
    // kept. Where it has depth, that becomes near / distance along the gaze: 1 near, 0 infinitely
    // far (as OpenXR says it: nearZ infinite, farZ = EyeView::near, depths 0 to 1); with clip
    // control at GL_ZERO_TO_ONE. Whatever state was set before: afterwards the framebuffer is bound
    // and its viewport set, and all other state that drawing needs has the values of a new context.
    // Throws PictureError where there is no room for it, std::invalid_argument for a view without
    // meaning.
    virtual void paint(const EyeView& view, const EyeLook& look, const EyeTarget& target,
                       int eye = 0) = 0;
    virtual std::string name() const = 0;  // the GL renderer
};

}  // namespace knead
