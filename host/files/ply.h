// PLY as tables of numbers: ASCII or binary of either byte order, scalar and list properties.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace knead {

// Integers come before the others. 64-bit ones are exact up to 2^53.
enum class PlyType : int { i8, u8, i16, u16, i32, u32, i64, u64, f16, f32, f64, none };
struct PlyProperty {
    std::string name;
    bool list = false;
    PlyType type = PlyType::none;    // value type
    std::vector<double> values;      // one per row, or all lists concatenated
    std::vector<std::size_t> start;  // for a list: rows + 1 offsets into values
};
struct PlyElement {
    std::string name;
    std::size_t rows = 0;
    std::vector<PlyProperty> properties;
    const PlyProperty* find(const std::string& property) const;  // nullptr if absent
};
struct PlyFile {
    std::vector<std::string> comments;
    std::vector<PlyElement> elements;
    bool little_endian = false;                                // binary, little-endian
    std::size_t body = 0;                                      // offset of the first row [bytes]
    const PlyElement* find(const std::string& element) const;  // nullptr if absent
};

// Throws InputError with path and byte offset. In text, numbers are those of text_number(), with
// NaN and infinity. A header that declares more rows than the file can
// hold is rejected before any allocation for them.
PlyFile read_ply(const std::string& path);
PlyFile parse_ply(const std::string& bytes, const std::string& path);

// Parses the header only; `bytes` may end after it. No values.
PlyFile parse_ply_header(const std::string& bytes, const std::string& path);

// As parse_ply, but the rows of the first element of that name are passed to `visit` one by one,
// with values in the order of the properties, and not stored: a table of doubles would be twice the
// file. Lists in such rows and bytes after the last row are rejected.
using PlyVisit = std::function<void(std::size_t row, const double* values)>;
PlyFile parse_ply_rows(const std::string& bytes, const std::string& path,
                       const std::string& element, const PlyVisit& visit);

std::size_t size_of(PlyType type);  // [bytes]
double number_of(PlyType type, const char* little_endian);

// Value of a half-precision float (IEEE 754 binary16).
double half_number(std::uint16_t bits);

}  // namespace knead
