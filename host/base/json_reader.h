// JSON read strictly: comments are allowed, but an unknown key, a key given twice, a wrong type or
// a number out of range is an InputError that says where (file and JSON pointer), what was
// expected, with unit and range, and what was found.
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

constexpr std::size_t max_json_bytes = 16u << 20;  // of a document

// Throws InputError with file, line, column and byte offset.
Json parse_json(const std::string& text, const std::string& file);
// Throws InputError where the file is missing, not a regular file, or larger than that.
Json read_json(const std::string& file);

// The whole of a regular file, or of the standard input where is_standard() (paths.h), however
// often it is asked for; throws InputError. Shared by all readers of files.
std::string read_text(const std::string& file, std::size_t max_bytes);
constexpr std::size_t max_file_bytes = std::size_t(4) << 30;  // of meshes and clouds
// Its first bytes, as many as there are up to `most`, of a file of any size.
std::string read_start(const std::string& file, std::size_t most);

// The candidate with the fewest slips of typing (insertion, deletion, exchange, swap of
// neighbours) from `word`; "" without candidates.
std::string nearest_name(const std::string& word, const std::vector<std::string>& candidates);
// The same, but "" where even the nearest is too far off to have been meant.
std::string likely_name(const std::string& word, const std::vector<std::string>& candidates);
// Those of the names that were asked for; all where none was. Throws UsageError for one that there
// is not: "no KIND ..., there are ...".
std::vector<std::string> names_asked(const std::string& kind, const std::vector<std::string>& asked,
                                     const std::vector<std::string>& names);

// What a number may be. `unit` is "" for a plain number.
struct Bounds {
    double low, high;
    const char* unit = "";
    bool above = false;  // low itself is not allowed
};
std::string described(const Bounds& range);

// How a value is told in a message: its type, and itself cut to 60 characters.
std::string described(const Json& value);

// One object of the document. A key is known once it has been read; all others are errors.
class ObjectReader {
  public:
    using Body = std::function<void(ObjectReader&)>;

    // Reads `value` by `body`, then refuses unknown keys.
    static void read(const Json& value, const std::string& file, const std::string& pointer,
                     const Body& body);

    bool has(const std::string& key);
    const Json* find(const std::string& key);  // nullptr where absent
    const Json& required(const std::string& key, const std::string& expected);

    double number(const std::string& key, Bounds range, double fallback);
    double number(const std::string& key, Bounds range);
    int whole(const std::string& key, int low, int high, int fallback);
    bool flag(const std::string& key, bool fallback);
    std::string text(const std::string& key, const std::string& fallback);
    // The path of the file `name` beside the document. It must stay there, for a document from
    // elsewhere names no file outside its own folder; `otherwise` is added to what it says then.
    std::string beside(const std::string& key, const std::string& name,
                       const std::string& otherwise = "") const;
    Vec3<double> vector(const std::string& key, Bounds each, Vec3<double> fallback);
    Vec3<double> vector(const std::string& key, Bounds each);
    // One of the named values.
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
    // Reads the object under `key`; where it is absent, `body` sees an empty one.
    void object(const std::string& key, const Body& body);

    // Where a key has the name it had in older files: an InputError that says the new one.
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

// A number as a reader of messages wants it: shortest form that is the same double.
std::string short_number(double value);

}  // namespace knead
