// What a frame of both eyes takes that shows clay, splats or both, made on the GPU: shared with
// OpenGL there, or by way of host memory.
//
// A frame gives a painter another mesh and draws the splats anew, then paints both eyes. `frame` is
// the host's wall time until OpenGL has drawn it, `issued` until the host was through, `paint` what
// OpenGL's timers say of the two pictures. The host's way begins with the mesh on the device, too.
// usage: bench_eyes [frames=200] [load=660k] [nodes=128] [width=2064] [height=2208] [samples=1]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#if KNEAD_HAS_GL
#include "host/bench/ball.h"
#include "host/picture/splat_layer.h"
#include "host/splats/generate.h"
#include "host/surface/gpu_surface.h"
#include "render/context.h"
#include "render/gl.h"
#endif

namespace {

#if KNEAD_HAS_GL
using namespace knead;

struct Case {
    int frames = 200;
    std::string load = "660k";
    int nodes = 128, width = 2064, height = 2208, samples = 1;
};

constexpr Vec3<float> middle{0.5f, 0.5f, 0.5f};

std::vector<EyeView> views_of(const Case& what)
{
    const Vec3<float> from{0.5f, 0.65f, 1.35f};
    std::vector<EyeView> views(2, eye_view({from, middle, 1.6f, what.width, what.height}));
    views[0].position.x -= 0.032f, views[1].position.x += 0.032f;
    return views;
}

SplatCloud cloud_of(const std::string& name)
{
    for (const SplatLoad& load : splat_loads()) {
        if (load.name != name) continue;
        SplatCloud cloud = generated(load);
        for (Vec3<float>& x : cloud.centre) x = x + middle + Vec3<float>{0.2f, 0, 0.1f};
        sort_by_place(cloud);
        return cloud;
    }
    throw std::invalid_argument("no load " + name);
}

// The clay at two moments, so that every frame has another mesh; on the device where there is one.
struct Clay {
    std::shared_ptr<const DeviceMesh> device[2];
    std::vector<Mesh> host[2];
};
Clay clay_of(const Case& what, Device device)
{
    Setup setup = ball(what.nodes / 2);
    SurfaceOptions options;
    options.lattice = {{what.nodes, what.nodes, what.nodes}, 1.0f / float(what.nodes)};
    std::unique_ptr<GpuSurface> surface;
    if (device.kind == DeviceKind::cuda)
        surface = std::make_unique<GpuSurface>(setup.particles, setup.materials, options);
    Clay made;
    for (int k = 0; k < 2; ++k) {
        if (surface)
            made.device[k] = surface->kept(setup.particles);
        else
            made.host[k] = knead::surface(setup.particles, setup.materials, options);
        for (Particle<double>& q : setup.particles)
            q.x.y = 0.5 + 0.98 * (q.x.y - 0.5);  // a little flatter
    }
    return made;
}

struct Eyes {
    Texture colour[2], depth[2];
    Framebuffer frame[2];
    explicit Eyes(const Case& what)
    {
        for (int e = 0; e < 2; ++e) {
            colour[e] = texture(GL_TEXTURE_2D), depth[e] = texture(GL_TEXTURE_2D);
            frame[e] = framebuffer();
            glTextureStorage2D(colour[e], 1, GL_SRGB8_ALPHA8, what.width, what.height);
            glTextureStorage2D(depth[e], 1, GL_DEPTH_COMPONENT32F, what.width, what.height);
            glNamedFramebufferTexture(frame[e], GL_COLOR_ATTACHMENT0, colour[e], 0);
            glNamedFramebufferTexture(frame[e], GL_DEPTH_ATTACHMENT, depth[e], 0);
        }
    }
};

struct Times {
    std::vector<double> frame, issued, paint, raster;  // [s]
};

std::string three(std::vector<double> seconds)  // median, 95th and 99th percentile [ms]
{
    std::sort(seconds.begin(), seconds.end());
    const auto at = [&](double share) {
        return 1e3 *
               seconds[std::min(seconds.size() - 1, std::size_t(share * double(seconds.size())))];
    };
    return fmt::format("{:8.3f} {:8.3f} {:8.3f}", at(0.5), at(0.95), at(0.99));
}

// One way of one content.
struct Scene {
    EyePainter& painter;
    const Clay* clay;     // null: none
    SplatDrawer* splats;  // null: none
};

void set(const Scene& scene, const std::vector<EyeView>& views, long version)
{
    if (scene.clay) {
        const std::size_t k = std::size_t(version % 2);
        if (scene.clay->device[k])
            scene.painter.set_device_clay(*scene.clay->device[k], version);
        else
            scene.painter.set_clay(scene.clay->host[k], version);
    }
    if (scene.splats) scene.splats->draw(scene.painter, views, {}, true);
}

Times measured(const Scene& scene, const Case& what, const Eyes& eyes)
{
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point t) {
        return std::chrono::duration<double>(Clock::now() - t).count();
    };
    const std::vector<EyeView> views = views_of(what);
    EyeLook look;
    look.stage = {middle, 1};
    GLuint query = 0;
    glGenQueries(1, &query);
    Times times;
    const int warm = std::min(10, what.frames);
    for (int k = 0; k < warm + what.frames; ++k) {
        glFinish();
        const Clock::time_point start = Clock::now();
        set(scene, views, k + 1);
        glBeginQuery(GL_TIME_ELAPSED, query);
        for (int e = 0; e < 2; ++e)
            scene.painter.paint(views[std::size_t(e)], look, {eyes.frame[e], 0, 0, true}, e);
        glEndQuery(GL_TIME_ELAPSED);
        const double issued = since(start);
        glFinish();
        const double whole = since(start);
        GLuint64 nanoseconds = 0;
        glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
        if (k < warm) continue;
        times.frame.push_back(whole), times.issued.push_back(issued);
        times.paint.push_back(1e-9 * double(nanoseconds));
        if (scene.splats) times.raster.push_back(scene.splats->seconds());
    }
    glDeleteQueries(1, &query);
    return times;
}

int run(const Case& what)
{
    const Device device = resolved(parse_device("auto"));
    const Context context;
    const Context::Bound bound(context);
    fmt::print("{}\n{} frames of 2 x {} x {}, {} samples a pixel\n", context.name(), what.frames,
               what.width, what.height, what.samples);
    const Eyes eyes(what);
    const Clay clay = clay_of(what, device);
    if (clay.device[0])
        fmt::print("clay: {} vertices, {} triangles\n", clay.device[0]->vertices(),
                   clay.device[0]->triangles());
    SplatDrawer splats(cloud_of(what.load), device, 1);
    fmt::print("splats: {}\n\n{:<8} {:<7} {:<26}   {:<26}   {:<26}   {:<26}\n", what.load, "", "",
               "frame [ms] p50 p95 p99", "issued", "paint", "rasteriser");
    int errors = 0;
    for (const bool share : {true, false}) {
        const std::unique_ptr<EyePainter> painter = EyePainter::open(what.samples, share);
        const Sharing way = device.kind == DeviceKind::cuda ? painter->sharing(device.index)
                                                            : Sharing{false, "no CUDA device"};
        fmt::print("{}\n", way.text);
        for (const char* content : {"clay", "splats", "both"}) {
            const std::string named = content;
            for (int e = 0; e < 2; ++e) painter->set_splats(e, SplatLayer{});
            painter->set_clay(std::vector<Mesh>{}, -1);
            const Times t = measured({*painter, named != "splats" ? &clay : nullptr,
                                      named != "clay" ? &splats : nullptr},
                                     what, eyes);
            fmt::print("{:<8} {:<7} {}   {}   {}", content, way.shared ? "shared" : "host",
                       three(t.frame), three(t.issued), three(t.paint));
            fmt::print("   {}\n", t.raster.empty() ? "" : three(t.raster));
            std::fflush(stdout);
        }
        while (glGetError() != GL_NO_ERROR) ++errors;
    }
    if (errors) fmt::print("{} errors of OpenGL\n", errors);
    return errors ? 1 : 0;
}

#endif

}  // namespace

int main([[maybe_unused]] int count, [[maybe_unused]] char** words)
{
#if KNEAD_HAS_GL
    Case what;
    const auto number = [&](int at, int otherwise) {
        return count > at ? std::atoi(words[at]) : otherwise;
    };
    what.frames = number(1, what.frames);
    if (count > 2) what.load = words[2];
    what.nodes = number(3, what.nodes), what.width = number(4, what.width);
    what.height = number(5, what.height), what.samples = number(6, what.samples);
    if (what.frames < 1 || what.nodes < 16 || what.nodes > 512 || what.width < 1 ||
        what.width > 8192 || what.height < 1 || what.height > 8192) {
        std::fprintf(stderr,
                     "usage: bench_eyes [frames=200] [load=660k] [nodes=128] [width=2064] "
                     "[height=2208] [samples=1]\n");
        return 2;
    }
    try {
        return run(what);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
#else
    std::fprintf(stderr, "this build has no OpenGL\n");
    return 4;
#endif
}
