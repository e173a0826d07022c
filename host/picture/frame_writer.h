// Pictures and a video of a run, where this machine can make them.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "host/files/video.h"
#include "host/session/loop.h"
#include "host/splats/cloud.h"
#include "render/painter.h"

namespace knead {

// frame_00010.png
std::string picture_name(int frame);
// The paths of the pictures in the folder of a run, by their numbers.
std::vector<std::string> pictures_in(const std::string& run);
// Removes the pictures that an earlier run left in the folder: files of exactly such names, and
// nothing else. Throws OutputError.
void remove_pictures(const std::string& folder);
// Removes what is left of pictures that were not written to their end.
void remove_partial_pictures(const std::string& folder);

class FrameWriter {
  public:
    // `folder` receives a picture_name() a picture; with `video`, its frames `rate` per second also
    // make that file. Throws std::runtime_error with the reason where there is no OpenGL, or where
    // it draws no pictures of the scene's size, OutputError where the folder cannot be made.
    FrameWriter(const Scene& scene, std::string folder, std::string video, double rate);
    // `splats`: those of the scene as they are by then, in the order of the solver's Gaussians;
    // they are drawn in place of the clay of objects that have them. Throws OutputError, and
    // PictureError where this picture alone cannot be made.
    void add(const Frame& frame, const std::vector<Mesh>& meshes, const SplatCloud& splats = {},
             const std::vector<Gaussian<double>>& gaussians = {});
    // True: a picture under way, drawn or written, is given up, by a PictureError.
    void give_up_when(std::function<bool()> asked)
    {
        give_up = asked;
        painter->give_up_when(std::move(asked));
    }
    void close();  // ends the video; throws OutputError
    int count() const { return pictures; }
    std::string renderer() const { return painter->name(); }

  private:
    bool has_splats(int category) const;

    const Scene& scene;
    std::string folder, video_path;
    std::function<bool()> give_up;
    double rate;
    std::unique_ptr<Painter> painter;
    std::unique_ptr<Video> video;
    int pictures = 0;
};

}  // namespace knead
