// One object of a scene and its material as JSON: the reader, and the writer that is its inverse.
// Every key of `objects` in a scene appears here once; docs/reference/formats.md documents them.
#pragma once
#include <string>
#include <vector>

#include "host/base/json_reader.h"
#include "host/scene/scene.h"
#include "host/scene/strand.h"

namespace knead {

// Reads an object with all its keys, in the frame of the document. `folder`: where the files lie
// that it names by a relative path, and it may then name others by an absolute one; "": beside the
// document, and no others. Throws InputError.
Object read_object(ObjectReader& r, const std::string& default_name,
                   const std::string& folder = "");
// A preset's name, {"preset": name, ...changes}, or nothing: "clay". Throws InputError.
MaterialSpec read_material(ObjectReader& r, const std::string& key);

// What read_object() reads again with the same values, to the bit, in a document at `path`: names,
// shape, pose, motion and the stated material. Preconditions: centre is in the frame of the
// document, rotation is a unit_rotation(), and files are inside the document's folder.
Json json_of(const Object& object, const std::string& path = "");
// {"preset": name} and what differs from that preset. read_material() reads the same values, to
// the bit, if the material is valid and normalised(). Unknown names are those of "clay".
Json json_of(const MaterialSpec& material);

// A material whose name is a preset's ("clay" unless it is one already), whose quantities that its
// plasticity does not use are those of this preset, and, if it is valid, whose others lie in their
// ranges: fault_of() allows for rounding at their ends.
MaterialSpec normalised(MaterialSpec material);

// [[x, y], ...]: the outline of a strand's section. Throws InputError.
std::vector<Point2> read_outline(ObjectReader& r, const std::string& key);
Json json_of(const std::vector<Point2>& outline);

// [w, x, y, z] of length 1 within 0.001, or nothing: no rotation. Throws InputError.
Quat<double> read_rotation(ObjectReader& r, const std::string& key);
// The rotation divided by its length. One that has the length 1 within rounding stays as it is, so
// that repeated use changes nothing.
Quat<double> unit_rotation(Quat<double> rotation);

}  // namespace knead
