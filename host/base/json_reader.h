// Strict JSON reader. Comments are allowed. Unknown keys, duplicate keys, wrong types and numbers
// out of range throw an InputError with place (file and JSON pointer), expected value with unit and
// range, and found value.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cuda/math/vec.h"
#include "host/base/errors.h"

namespace knead {

using Json = nlohmann::json;

constexpr std::size_t max_json_bytes = 16u << 20;  // per document

// Throws InputError with file, line, column and byte offset.
Json parse_json(const std::string& text, const std::string& file);
// Throws InputError if the file is missing, not a regular file, or larger than max_json_bytes.
Json read_json(const std::string& file);

// The contents of a regular file, or of standard input if is_standard() (paths.h); repeatable.
// Throws InputError. Used by all file readers.
std::string read_text(const std::string& file, std::size_t max_bytes);
constexpr std::size_t max_file_bytes = std::size_t(4) << 30;  // for meshes and point clouds
// The first bytes of a file of any size, up to `most`.
std::string read_start(const std::string& file, std::size_t most);

// The candidate with the smallest edit distance (insertion, deletion, substitution, transposition)
// from `word`; "" without candidates.
std::string nearest_name(const std::string& word, const std::vector<std::string>& candidates);
// The same, but "" if the distance is too large for a typing error.
std::string likely_name(const std::string& word, const std::vector<std::string>& candidates);
// Returns `asked`, or all names if it is empty. Throws UsageError for an unknown name: "no KIND
// ..., there are ...".
std::vector<std::string> requested_names(const std::string& kind,
                                         const std::vector<std::string>& requested,
                                         const std::vector<std::string>& names);

// Valid range of a number. `unit` is "" if dimensionless.
struct Bounds {
    double low, high;
    const char* unit = "";
    bool above = false;  // excludes `low` itself
};
std::string described(const Bounds& range);

// A value in error messages: its type and its text, cut to 60 characters.
std::string described(const Json& value);

// Reads one object of the document. Keys that are never read are errors.
class ObjectReader {
  public:
    using Body = std::function<void(ObjectReader&)>;

    // Calls `body` on `value`, then throws for unknown keys.
    static void read(const Json& value, const std::string& file, const std::string& pointer,
                     const Body& body);

    bool has(const std::string& key);
    const Json* find(const std::string& key);  // nullptr if absent
    const Json& required(const std::string& key, const std::string& expected);

    double number(const std::string& key, Bounds range, double fallback);
    double number(const std::string& key, Bounds range);
    int whole(const std::string& key, int low, int high, int fallback);
    bool flag(const std::string& key, bool fallback);
    std::string text(const std::string& key, const std::string& fallback);
    // Path of the file `name`, relative to the document. Throws if it is outside the document's
    // folder, because a downloaded document must not name other files; `otherwise` is appended to
    // the message.
    std::string beside(const std::string& key, const std::string& name,
                       const std::string& otherwise = "") const;
    Vec3<double> vector(const std::string& key, Bounds each, Vec3<double> fallback);
    Vec3<double> vector(const std::string& key, Bounds each);
    // Maps one of the names to its value.
    template <class T>
    T choice(const std::string& key, const std::vector<std::pair<std::string, T>>& named,
             T fallback)
    {
        if (!has(key)) return fallback;
        std::vector<std::string> names;
        names.reserve(named.size());
        for (const auto& [name, value] : named) names.push_back(name);
        return named[chosen(key, names)].second;
    }
    // Reads the object under `key`; if it is absent, calls `body` on an empty object.
    void object(const std::string& key, const Body& body);

    // Throws an InputError with the new name if the key has its name of older files.
    void refuse_renamed(const std::string& old, const std::string& key) const;

    std::string pointer(const std::string& key) const;  // of a key in this object
    const std::string& file() const { return path; }
    [[noreturn]] void fail(const std::string& key, const std::string& expected,
                           const std::string& found) const;

  private:
    ObjectReader(const Json& value, std::string file, std::string pointer);
    std::size_t chosen(const std::string& key, const std::vector<std::string>& names);
    double checked(const Json& value, const std::string& pointer, const Bounds& range) const;
    std::vector<std::string> unknown() const;
    void refuse_unknown() const;

    const Json* object_value;
    std::string path, where;
    std::vector<std::string> known;
};

// A number in error messages: the shortest text that converts to the same double.
std::string short_number(double value);

}  // namespace knead
