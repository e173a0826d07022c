// Live pictures: clay, hands, floor and splats for one eye, drawn with OpenGL 4.5 into the caller's
// framebuffer in the current context. Lighting as in Painter with fewer lamps, fast enough for
// every frame of a window or headset.
#pragma once
#include <array>
#include <functional>
#include <map>
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

// Loads the OpenGL functions for a current context made elsewhere, e.g. by GLFW or for OpenXR;
// Context (render/context.h) loads them itself. Throws std::runtime_error below OpenGL 4.5.
using GlAddress = void (*(*)(const char* name))();
void load_gl(GlAddress address);

// Pose and frustum of an eye. Axes as in OpenXR: x right, y up, view axis -z.
struct EyeView {
    Vec3<float> position{};            // [m]
    Quat<float> rotation{1, 0, 0, 0};  // unit; of the axes
    float left = -1, right = 1, down = -1,
          up = 1;               // tangents of the frustum's sides: left < right, down < up
    float near = 0.01f;         // near plane [m]
    int width = 0, height = 0;  // pixels
};
EyeView eye_view(const Camera& camera);
// The same eye for the splat rasteriser, whose y axis points down.
Eye<float> splat_eye(const EyeView& view);

// Render target.
struct EyeTarget {
    unsigned framebuffer = 0;  // GL name; 0: the window's
    int x = 0, y = 0;          // lower left corner of the picture [pixels]
    // True for sRGB and floating-point formats: linear values are written, and GL encodes them if
    // the format is sRGB. Otherwise sRGB values are written.
    bool linear = false;
};

// Appearance of a picture.
struct EyeLook {
    float floor = 0;  // height of the ground [m]
    bool floor_seen = true;
    bool transparent = false;  // no backdrop: alpha is 0 where nothing is drawn
    int highlight = -1;        // category of clay drawn with a glowing rim; -1: none
    // Extrapolates the clay by this fraction of its displacement since the previous meshes
    // (Mesh::advance).
    float extrapolation = 0;
    Vec3<float> light{-0.75f, 1, 0.45f};  // direction to the key light, any length
    Ball stage{{0.5f, 0.25f, 0.5f}, 1};   // lit region: clay outside casts no shadow
};

// Rasterised splats for one eye, any resolution, top row first.
struct SplatLayer {
    int width = 0, height = 0;  // 0: none
    std::vector<float> colour;  // 4 per pixel: sRGB colour times alpha; alpha
    std::vector<float> depth;   // along the view axis [m]; 1e30 or infinity: empty
};

// Colours of clay in place of those of its categories, linear RGB.
struct ClayColours {
    std::map<int, Vec3<float>> of_category;
    // Of each vertex of the host's meshes, in their order; none of a mesh: of its category.
    std::vector<std::vector<Vec3<float>>> of_vertices;
    long version = 0;  // of the colours; equal ones are not uploaded again
};

class EyePainter {
  public:
    // Precondition: a context is current and its functions are loaded; it must be current whenever
    // the painter is used or deleted. `samples` per pixel, with twice as many shadow lookups: 1, 2,
    // 4 or 8; use 1 on software renderers. `share`: allow CUDA to write GL objects directly if the
    // device draws this context. Throws std::runtime_error with the reason if this OpenGL is
    // insufficient.
    static std::unique_ptr<EyePainter> open(int samples = 4, bool share = true);
    virtual ~EyePainter() = default;

    // Whether this CUDA device shares memory with the context; determined once.
    virtual const Sharing& sharing(int device) = 0;

    // Sets the clay's meshes; uploads only if `version` or `hidden` has changed. Clay of the
    // categories `unseen` only casts a shadow, because splats are drawn in its place; clay of those
    // `hidden` is left out. Throws std::invalid_argument for an invalid mesh, or for as many
    // colours as it does not have vertices.
    virtual void set_clay(const std::vector<Mesh>& meshes, long version,
                          const std::vector<int>& unseen = {}, const std::vector<int>& hidden = {},
                          const ClayColours& colours = {}) = 0;
    // The same for a mesh on a CUDA device: shared if possible, without blocking the host; else
    // copied through the host.
    virtual void set_device_clay(const DeviceMesh& mesh, long version,
                                 const std::vector<int>& unseen = {},
                                 const std::vector<int>& hidden = {},
                                 const ClayColours& colours = {}) = 0;
    virtual void set_hands(const std::vector<HandLook>& hands) = 0;
    void set_hands(const std::vector<DrawPrimitive>& primitives)
    {
        set_hands(std::vector<HandLook>{{primitives, {}, 1, true}});
    }
    // Splats of eye 0 or 1, until set again. Throws std::invalid_argument if the sizes of the
    // arrays do not match.
    virtual void set_splats(int eye, const SplatLayer& layer) = 0;
    // The same from the caller's textures, laid out as a SplatLayer (GL_RGBA of any floating-point
    // or normalised format; GL_R32F). 0: none.
    virtual void set_splats(int eye, unsigned colour, unsigned depth) = 0;
    // Hidden area of eye 0 or 1, until set again: triangles, three corners each, in tangents (x
    // right, y up). There nothing is shaded; the target gets black, alpha 0 and infinite depth.
    // Throws std::invalid_argument if a corner is not finite or the number of corners is not a
    // multiple of 3.
    virtual void set_hidden(int eye, const std::vector<std::array<float, 2>>& corners) = 0;
    // Rasterises the splats of all eyes of the frame (0 and 1, or 0 alone) on a CUDA device, in one
    // depth order, without blocking the host. Returns false and does nothing if the device cannot
    // share memory. `moved`, if not null, replaces positions and deformations of the first splats.
    // Throws as GpuRaster::launch().
    virtual bool set_splats(GpuRaster& raster, const SplatFrame& frame,
                            const DeviceGaussians* moved = nullptr) = 0;
    // Sets the largest size of shared pictures to come [pixels], so that none reallocates textures.
    virtual void expect_splats(int width, int height) = 0;
    // Recent device time of a shared picture [s]; 0: unknown.
    virtual double splat_seconds() const = 0;

    // Draws everything set so far, with the splats of `eye` 0 or 1. Overwrites the whole viewport.
    // A depth buffer gets near / distance along the view axis: 1 near, 0 infinitely far (in OpenXR
    // nearZ infinite, farZ = EyeView::near, depths 0 to 1), with clip control GL_ZERO_TO_ONE. Any
    // GL state on entry is allowed; on return the framebuffer is bound, its viewport set, and all
    // other state used has the defaults of a new context. Throws PictureError if out of memory,
    // std::invalid_argument for an invalid view.
    //
    // `between`, if not empty, is called once everything except the hands is drawn, and draws into
    // the target that it is given: the painter's own multisampled framebuffer, with linear values
    // and the depths above. That framebuffer is then bound with its viewport, depth test, sRGB
    // encoding and GL_ZERO_TO_ONE on; any state may be left, but the attachments must stay. Its
    // fragments write a colour times alpha (output 0), 1 (output 1) and their depth. Where they
    // pass the depth test, e.g. everywhere with GL_ALWAYS, they replace clay, floor and splats,
    // nearer ones too; hands are then drawn with depth test against them.
    using DrawBetween = std::function<void(const EyeTarget& target)>;
    virtual void paint(const EyeView& view, const EyeLook& look, const EyeTarget& target,
                       int eye = 0, const DrawBetween& between = {}) = 0;
    virtual std::string name() const = 0;  // the GL renderer
};

}  // namespace knead
