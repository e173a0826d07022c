// Where the clay of each object is: the document has only the poses that commands have set.
#pragma once
#include <vector>

#include "cuda/math/box.h"
#include "host/document/document.h"
#include "host/surface/mesh.h"

namespace knead {

struct ObjectPlace {
    ObjectId object;
    Box3<double> box;                 // of the particles, in the simulation's frame [m]
    Vec3<double> centre{};            // of mass
    double spacing = 0;               // of the particles, the largest of its parts [m]
    std::vector<Vec3<float>> some{};  // at most `most_samples` of the particles, evenly taken
    double apart = 0;                 // about the distance between neighbours of these [m]
    static constexpr std::size_t most_samples = 4096;
};

struct ObjectPlaces {
    int history = 0;               // LiveState::history when taken
    long frame = 0;                // number of the last completed frame
    long edits = 0;                // of the clay so far
    double took = 0;               // time to find them [s]
    std::vector<ObjectPlace> all;  // of objects that have clay, in the order of the document

    const ObjectPlace* find(ObjectId object) const;  // nullptr: it has no clay
    // The object of a category whose clay is nearest to `x`; 0: none of them has clay.
    // `document`: of the same moment.
    ObjectId nearest(const Document& document, int category, Vec3<double> x) const;
};

// Of these objects together; empty boxes and zeros if none has clay.
struct CommonPlace {
    Box3<double> box;
    Vec3<double> centre{};  // the middle of the centres of mass
    double spacing = 0;
    bool any() const { return spacing > 0; }
};
CommonPlace common_place(const ObjectPlaces& places, const std::vector<ObjectId>& objects);

// The object that each vertex of a category's surface belongs to, by the nearest of the sampled
// particles; 0 of all if no object of the category has clay.
std::vector<ObjectId> objects_of(const Mesh& mesh, const Document& document,
                                 const ObjectPlaces& places);
// The surface of some objects, and that of the others.
struct PartedMeshes {
    std::vector<Mesh> some, others;
};
PartedMeshes parted(const std::vector<Mesh>& meshes, const Document& document,
                    const ObjectPlaces& places, const std::vector<ObjectId>& some);

}  // namespace knead
