// Where objects are, kept up to date while it is shown, and the boxes that are drawn around them.
#pragma once
#include <map>
#include <memory>

#include "host/live/live_session.h"

namespace knead {

class PlaceWatch {
  public:
    // Null: none were found yet.
    std::shared_ptr<const ObjectPlaces> places;

    // Requests them after each change of the document, and while the clay moves at most four times
    // a second, for at most a fiftieth of the time. In clay so large that the search would delay a
    // frame, only after changes. `shown`: something that depends on them is. `waits`: for the
    // answer, in stepped sessions. `now` [s], ascending. `seen`: the least change of a box that can
    // be seen [m].
    void follow(const LiveState& state, LiveSession& session, bool shown, bool waits, double now,
                double seen);
    // At once, at `now` [s].
    void find(LiveSession& session, double now);
    // Null: it has no clay.
    const Box3<double>* box(ObjectId object) const;

  private:
    double requested_at_ = -1e9;
    DocumentPtr of_;  // document then
    std::map<ObjectId, Box3<double>> boxes_;
};

}  // namespace knead
