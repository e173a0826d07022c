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

// A medial primitive to be drawn as it is, e.g. a finger.
struct DrawPrimitive {
    int count;  // 1 ball, 2 cone, 3 slab
    Sphere<float> sphere[3];
};

// One hand, or what it holds.
struct HandLook {
    std::vector<DrawPrimitive> primitives;  // drawn as their hulls
    std::vector<Mesh> skins;                // drawn as they are; categories do not count
    float opacity = 1;                      // [0, 1]; below 1/2 it casts no shadow
    bool skin = true;                       // false: a thing, of wood
    bool metal = false;                     // of steel instead
    Vec3<float> glow{0, 0, 0};              // light of its rim, linear; eyes alone show it
};

class Painter {
  public:
    // Throws std::runtime_error, with the reason, where no GL context can be made.
    static std::unique_ptr<Painter> open();
    virtual ~Painter() = default;
    // `floor` is the height of the ground plane [m]. What is `unseen` casts its shadow all the
    // same: splats will be put where it is. Throws PictureError where the GL has no room for it,
    // std::invalid_argument for what cannot be drawn.
    // Hands have the opacity of the camera, whatever their own.
    virtual Image paint(const std::vector<Mesh>& meshes, const std::vector<HandLook>& hands,
                        const Camera& camera, float floor, const std::vector<Mesh>& unseen) = 0;
    Image paint(const std::vector<Mesh>& meshes, const std::vector<DrawPrimitive>& primitives,
                const Camera& camera, float floor, const std::vector<Mesh>& unseen = {})
    {
        return paint(meshes, std::vector<HandLook>{{primitives, {}, 1, true}}, camera, floor,
                     unseen);
    }
    // How far meshes and hands lie in the last picture, along the camera's gaze [m], top row first;
    // infinity where there is neither.
    virtual std::vector<float> depths() = 0;
    virtual std::string name() const = 0;  // the GL renderer
    virtual int largest_side() const = 0;  // of a picture, by the GL's limits [pixels]
    // Asked again and again while a picture is made, which may take seconds where the processor
    // draws; true: it is given up, by a PictureError.
    void give_up_when(std::function<bool()> asked) { given_up = std::move(asked); }

  protected:
    std::function<bool()> given_up = [] { return false; };
};

}  // namespace knead
