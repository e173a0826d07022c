// Headless pictures: clay, hands and floor with light, shade, contact shadow and ambient occlusion.
#pragma once
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/contact/medial.h"
#include "host/files/image.h"
#include "host/surface/mesh.h"

namespace knead {

struct Camera {
    Vec3<float> eye, target;  // [m]
    float field = 0.6f;       // vertical field of view [rad]
    int width = 960, height = 720;
    float hands = 1;  // opacity of the hands in [0, 1]; at 0 they cast no shadow either
};

// A medial primitive in its posed state, e.g. of a finger.
struct DrawPrimitive {
    int count;  // 1 ball, 2 cone, 3 slab
    Sphere<float> sphere[3];
};

// One hand, or an object it holds.
struct HandLook {
    std::vector<DrawPrimitive> primitives;  // drawn as their hulls
    std::vector<Mesh> skins;                // drawn as given; categories are ignored
    float opacity = 1;                      // [0, 1]; below 1/2 it casts no shadow
    bool skin = true;                       // false: an object, of wood
    bool metal = false;                     // object of steel
    Vec3<float> glow{0, 0, 0};              // rim light, linear RGB; EyePainter only
    bool mark = false;                      // in the colour of its glow, without a shadow
};

class Painter {
  public:
    // Throws std::runtime_error with the reason if no GL context can be created.
    static std::unique_ptr<Painter> open();
    virtual ~Painter() = default;
    // Draws a picture. `floor`: height of the ground plane [m]. `unseen` meshes only cast shadows,
    // because splats are drawn in their place. Hands are drawn with Camera::hands;
    // HandLook::opacity is ignored. Throws PictureError if GL is out of memory,
    // std::invalid_argument for invalid geometry.
    virtual Image paint(const std::vector<Mesh>& meshes, const std::vector<HandLook>& hands,
                        const Camera& camera, float floor, const std::vector<Mesh>& unseen) = 0;
    Image paint(const std::vector<Mesh>& meshes, const std::vector<DrawPrimitive>& primitives,
                const Camera& camera, float floor, const std::vector<Mesh>& unseen = {})
    {
        return paint(meshes, std::vector<HandLook>{{primitives, {}, 1, true}}, camera, floor,
                     unseen);
    }
    // Depth of meshes and hands in the last picture along the view axis [m], top row first;
    // infinity where empty.
    virtual std::vector<float> depths() = 0;
    virtual std::string name() const = 0;  // the GL renderer
    virtual int largest_side() const = 0;  // largest side of a picture, by GL limits [pixels]
    // Sets a callback polled while a picture is drawn, which may take seconds in software; when it
    // returns true, paint() throws PictureError.
    void give_up_when(std::function<bool()> when) { given_up = std::move(when); }

  protected:
    std::function<bool()> given_up = [] { return false; };
};

}  // namespace knead
