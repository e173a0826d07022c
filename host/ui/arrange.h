// Places for objects beside and between others, by the boxes of their clay.
#pragma once
#include <vector>

#include "host/session/object_places.h"

namespace knead {

// In the simulation's frame.
struct Surroundings {
    const ObjectPlaces& places;
    Box3<double> room;  // between the walls [m]
    double gap = 0;     // to be left beside other clay [m]
};

// From the chosen objects to a copy beside them, by their own width: along x, else along z, else
// above; the nearest place without other clay. If there is none, the first of these.
Vec3<double> beside(const Surroundings& around, const std::vector<ObjectId>& chosen);
// To the middle of the room, at their height, or above what is there.
Vec3<double> to_middle(const Surroundings& around, const std::vector<ObjectId>& chosen);

}  // namespace knead
