// Finds objects that were cut or torn into pieces: while hands press clay, and until it has
// settled.
#pragma once
#include <map>
#include <vector>

#include "host/session/scene_editor.h"

namespace knead {

class PieceWatch {
  public:
    explicit PieceWatch(const Scene& scene);
    // Call after each frame, with no frame in flight. `touched`: tools changed the clay in it.
    // Returns the objects that have been in two pieces or more for long enough, in order of id.
    std::vector<ObjectId> after_frame(const FrameResult& frame, bool touched,
                                      const SceneEditor& editor,
                                      const EditableSimulator& simulator);
    // The object could not be split: it is left alone until hands press clay again.
    void refused(ObjectId object) { left.insert_or_assign(object, true); }
    // The clay was replaced: nothing is looked at until hands press it.
    void restored();

  private:
    const bool on;
    const double seconds;     // of a frame
    const double calm_speed;  // slower clay has settled [m/s]
    const int every;          // frames between looks
    const int enough;         // looks
    bool armed = false, touching = false;
    double since_touch = 0;  // [s]
    long frames = 0;
    std::map<ObjectId, int> looks;  // in succession in which the object was in pieces
    std::map<ObjectId, bool> left;
};

}  // namespace knead
