// Writes the pictures and the video of a run, if the machine has OpenGL.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/document/document.h"
#include "host/files/video.h"
#include "host/session/loop.h"
#include "host/session/object_places.h"
#include "host/splats/cloud.h"
#include "render/painter.h"

namespace knead {

// frame_00010.png
std::string picture_name(int frame);
// Paths of the pictures in the folder of a run, sorted by number.
std::vector<std::string> pictures_in(const std::string& run);
// Removes the pictures of an earlier run from the folder: only files with the name of a picture.
// Throws OutputError.
void remove_pictures(const std::string& folder);
// Removes partially written pictures.
void remove_partial_pictures(const std::string& folder);

class FrameWriter {
  public:
    // Writes pictures to `folder`, named by picture_name(), and, unless "", the file `video` with
    // `rate` pictures per second. Throws std::runtime_error if there is no OpenGL or it cannot draw
    // pictures of the scene's size, OutputError if the folder cannot be created.
    FrameWriter(const Scene& scene, std::string folder, std::string video, double rate);
    // `splats`: current splats of the scene, in the order of the solver's Gaussians; drawn instead
    // of the clay of their objects. `document`: says which objects are of splats, and which are
    // hidden, and the colours of objects; null: those of the scene, none hidden. `places`: of the
    // objects, for the colours of a category whose objects differ; null: such a category has its
    // own. Throws OutputError, and PictureError if only this picture fails.
    void add(const FrameResult& frame, const std::vector<Mesh>& meshes,
             const SplatCloud& splats = {}, const std::vector<Gaussian<double>>& gaussians = {},
             const Document* document = nullptr, const ObjectPlaces* places = nullptr);
    // `asked`: polled while a picture is drawn or written; return true to abort it with a
    // PictureError.
    void give_up_when(std::function<bool()> when)
    {
        give_up = when;
        painter->give_up_when(std::move(when));
    }
    void close();  // ends the video; throws OutputError
    int count() const { return pictures; }
    std::string renderer() const { return painter->name(); }

  private:
    const Scene& scene;
    std::string folder, video_path;
    std::function<bool()> give_up;
    double rate;
    std::unique_ptr<Painter> painter;
    std::unique_ptr<Video> video;
    int pictures = 0;
};

}  // namespace knead
