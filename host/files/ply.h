// PLY as tables of numbers: ASCII or binary little-endian, scalar and list properties.
#pragma once
#include <string>
#include <vector>

namespace knead {

struct PlyProperty {
    std::string name;
    bool list = false;
    std::vector<double> values;      // one per row, or all lists one after the other
    std::vector<std::size_t> start;  // of a list: rows + 1 offsets into values
};
struct PlyElement {
    std::string name;
    std::size_t rows = 0;
    std::vector<PlyProperty> properties;
    const PlyProperty* find(const std::string& property) const;  // nullptr where absent
};
struct PlyFile {
    std::vector<std::string> comments;
    std::vector<PlyElement> elements;
    const PlyElement* find(const std::string& element) const;  // nullptr where absent
};

// Throws InputError with path and byte offset. A header that promises more rows than the file can
// hold is refused before anything is allocated for them.
PlyFile read_ply(const std::string& path);
PlyFile parse_ply(const std::string& bytes, const std::string& path);

}  // namespace knead
