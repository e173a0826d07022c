// Names of enumerators in scene files. Readers and writers use the same tables.
#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/scene.h"
#include "host/scene/strand.h"

namespace knead {

template <class T>
using Names = std::vector<std::pair<std::string, T>>;

inline const Names<ShapeKind> shape_kinds = {
    {"sphere", ShapeKind::sphere},       {"box", ShapeKind::box},
    {"cylinder", ShapeKind::cylinder},   {"splats", ShapeKind::splats},
    {"ellipsoid", ShapeKind::ellipsoid}, {"rounded_box", ShapeKind::rounded_box},
    {"cone", ShapeKind::cone},           {"capsule", ShapeKind::capsule},
    {"torus", ShapeKind::torus},         {"text", ShapeKind::text},
    {"strand", ShapeKind::strand},       {"mesh", ShapeKind::mesh}};
inline const Names<SectionKind> section_kinds = {{"circle", SectionKind::circle},
                                                 {"square", SectionKind::square},
                                                 {"star", SectionKind::star},
                                                 {"outline", SectionKind::outline}};
inline const Names<double> mesh_units = {
    {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}};  // [m]
inline const Names<UpAxis> up_axes = {{"x", UpAxis::x}, {"-x", UpAxis::minus_x},
                                      {"y", UpAxis::y}, {"-y", UpAxis::minus_y},
                                      {"z", UpAxis::z}, {"-z", UpAxis::minus_z}};
inline const Names<Elasticity> elasticities = {{"neo_hookean", Elasticity::neo_hookean},
                                               {"fixed_corotated", Elasticity::fixed_corotated},
                                               {"hencky", Elasticity::hencky}};
inline const Names<Plasticity> plasticities = {{"none", Plasticity::none},
                                               {"von_mises", Plasticity::von_mises},
                                               {"drucker_prager", Plasticity::drucker_prager},
                                               {"clamp", Plasticity::clamp},
                                               {"herschel_bulkley", Plasticity::herschel_bulkley},
                                               {"fluid", Plasticity::fluid}};
inline const Names<ContactMode> contact_modes = {{"sticky", ContactMode::sticky},
                                                 {"slip", ContactMode::slip},
                                                 {"separate", ContactMode::separate}};
// BodyContact::separate.
inline const Names<bool> category_contacts = {{"weld", false}, {"separate", true}};

// Throws std::out_of_range for a value that is not in the table.
template <class T>
const std::string& name_of(const Names<T>& names, T value)
{
    for (const auto& [name, one] : names)
        if (one == value) return name;
    throw std::out_of_range("an enumerator without a name");
}

}  // namespace knead
