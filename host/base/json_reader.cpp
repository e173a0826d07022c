#include "host/base/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/base/paths.h"

namespace knead {
namespace {

// Edit distance with swaps of neighbours (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b)
{
    const std::size_t n = b.size() + 1;
    std::vector<std::size_t> two(n), one(n), now(n);
    for (std::size_t j = 0; j < n; ++j) one[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        now[0] = i;
        for (std::size_t j = 1; j < n; ++j) {
            const std::size_t cost = a[i - 1] != b[j - 1];
            now[j] = std::min({one[j] + 1, now[j - 1] + 1, one[j - 1] + cost});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = std::min(now[j], two[j - 2] + 1);
        }
        std::swap(two, one);
        std::swap(one, now);
    }
    return one[n - 1];
}

std::string joined(const std::vector<std::string>& words)
{
    std::string all;
    for (const std::string& w : words) all += (all.empty() ? "\"" : ", \"") + w + "\"";
    return all;
}

}  // namespace

std::string short_number(double value) { return fmt::format("{}", value); }

std::string nearest_name(const std::string& word, const std::vector<std::string>& candidates)
{
    const std::string cut = word.substr(0, 100);
    std::string best;
    std::size_t min_slips = ~std::size_t(0);
    for (const std::string& c : candidates) {
        const std::size_t s = edit_distance(cut, c);
        if (s < min_slips) min_slips = s, best = c;
    }
    return best;
}

std::string likely_name(const std::string& word, const std::vector<std::string>& candidates)
{
    const std::string best = nearest_name(word, candidates);
    const std::size_t allowed = std::max<std::size_t>(2, best.size() / 3);
    return edit_distance(word.substr(0, 100), best) <= allowed ? best : "";
}

std::vector<std::string> requested_names(const std::string& kind,
                                         const std::vector<std::string>& requested,
                                         const std::vector<std::string>& names)
{
    for (const std::string& one : requested) {
        if (std::find(names.begin(), names.end(), one) != names.end()) continue;
        const std::string near = likely_name(one, names);
        throw UsageError(fmt::format("no {} \"{}\"{}; there are {}", kind, one.substr(0, 60),
                                     near.empty() ? "" : " (did you mean \"" + near + "\"?)",
                                     fmt::join(names, ", ")));
    }
    return requested.empty() ? names : requested;
}

namespace {

// The size of a regular file.
std::uintmax_t size_of(const std::string& file)
{
    namespace fs = std::filesystem;
    std::error_code problem;
    const fs::file_status status = fs::status(file, problem);
    if (status.type() == fs::file_type::not_found) throw InputError(file + ": no such file");
    if (!fs::status_known(status) || status.type() == fs::file_type::none)
        throw InputError(file + ": cannot be read: " + problem.message());
    if (!fs::is_regular_file(status))
        throw InputError(file + ": expected a regular file, found " +
                         (fs::is_directory(status) ? "a directory" : "something else"));
    const std::uintmax_t size = fs::file_size(file, problem);
    if (problem) throw InputError(file + ": cannot be read: " + problem.message());
    return size;
}

std::string read_bytes(const std::string& file, std::uintmax_t size)
{
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    std::string text(in ? std::size_t(size) : 0, '\0');
    if (!in || (size > 0 && !in.read(text.data(), std::streamsize(size))))
        throw InputError(file + ": cannot be read" +
                         (errno ? std::string(": ") + std::strerror(errno) : ""));
    return text;
}

// Reads standard input once and keeps it: the format is detected before the file is read.
const std::string& standard_input(std::size_t max_bytes)
{
    static std::string whole;
    static bool ended = false;
    char part[1 << 16];
    while (!ended && whole.size() <= max_bytes) {
        const std::size_t count = std::fread(part, 1, sizeof part, stdin);
        whole.append(part, count);
        ended = count == 0;
    }
    if (std::ferror(stdin)) throw InputError("-: the standard input cannot be read");
    return whole;
}

}  // namespace

std::string read_text(const std::string& file, std::size_t max_bytes)
{
    if (is_standard(file)) {
        const std::string& whole = standard_input(max_bytes);
        if (whole.size() <= max_bytes) return whole;
        throw InputError(fmt::format("{}: expected at most {} bytes, found more", file, max_bytes));
    }
    const std::uintmax_t size = size_of(file);
    if (size > max_bytes)
        throw InputError(
            fmt::format("{}: expected at most {} bytes, found {}", file, max_bytes, size));
    return read_bytes(file, size);
}

std::string read_start(const std::string& file, std::size_t most)
{
    if (is_standard(file)) return standard_input(most).substr(0, most);
    return read_bytes(file, std::min<std::uintmax_t>(size_of(file), most));
}

std::string described(const Bounds& r)
{
    const std::string unit = *r.unit ? std::string(" ") + r.unit : "";
    const char* low = r.above ? "above " : "at least ";
    if (std::isinf(r.low) && std::isinf(r.high))
        return "a finite number" + (*r.unit ? " in" + unit : "");
    if (std::isinf(r.high)) return "a number " + (low + short_number(r.low)) + unit;
    if (std::isinf(r.low)) return "a number at most " + short_number(r.high) + unit;
    return "a number " + (low + short_number(r.low)) + " and at most " + short_number(r.high) +
           unit;
}

std::string described(const Json& value)
{
    if (value.is_object()) return "an object";
    if (value.is_array()) return fmt::format("an array of {}", value.size());
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return value.is_string() ? "the text " + text : text;
}

ObjectReader::ObjectReader(const Json& value, std::string file, std::string pointer)
    : object_value(&value), path(std::move(file)), where(std::move(pointer))
{
    if (!value.is_object())
        throw InputError(fmt::format("{}: {}: expected an object, found {}", path,
                                     where.empty() ? "/" : where, described(value)));
}

void ObjectReader::read(const Json& value, const std::string& file, const std::string& pointer,
                        const Body& body)
{
    ObjectReader reader(value, file, pointer);
    body(reader);
    reader.refuse_unknown();
}

std::string ObjectReader::pointer(const std::string& key) const
{
    std::string escaped;
    for (char c : key) {
        if (c == '~')
            escaped += "~0";
        else if (c == '/')
            escaped += "~1";
        else
            escaped += c;
    }
    return where + "/" + escaped;
}

void ObjectReader::fail(const std::string& key, const std::string& expected,
                        const std::string& found) const
{
    throw InputError(
        fmt::format("{}: {}: expected {}, found {}", path, pointer(key), expected, found));
}

const Json* ObjectReader::find(const std::string& key)
{
    if (std::find(known.begin(), known.end(), key) == known.end()) known.push_back(key);
    const auto at = object_value->find(key);
    return at == object_value->end() ? nullptr : &*at;
}

bool ObjectReader::has(const std::string& key) { return find(key) != nullptr; }

const Json& ObjectReader::required(const std::string& key, const std::string& expected)
{
    if (const Json* value = find(key)) return *value;
    const std::string meant = likely_name(key, unknown());
    fail(key, expected, meant.empty() ? "nothing" : "nothing, but there is \"" + meant + "\"");
}

double ObjectReader::checked(const Json& value, const std::string& at, const Bounds& range) const
{
    const double x = value.is_number() ? value.get<double>() : std::nan("");
    const bool low = range.above ? x > range.low : x >= range.low;
    if (!std::isfinite(x) || !low || x > range.high)
        throw InputError(fmt::format("{}: {}: expected {}, found {}", path, at, described(range),
                                     described(value)));
    return x;
}

double ObjectReader::number(const std::string& key, Bounds range, double fallback)
{
    const Json* value = find(key);
    return value ? checked(*value, pointer(key), range) : fallback;
}

double ObjectReader::number(const std::string& key, Bounds range)
{
    return checked(required(key, described(range)), pointer(key), range);
}

int ObjectReader::whole(const std::string& key, int low, int high, int fallback)
{
    const Json* value = find(key);
    if (!value) return fallback;
    const std::string expected = fmt::format("a whole number from {} to {}", low, high);
    if (!value->is_number()) fail(key, expected, described(*value));
    const double x = value->get<double>();
    if (!(x >= low && x <= high) || x != std::floor(x)) fail(key, expected, described(*value));
    return int(x);
}

bool ObjectReader::flag(const std::string& key, bool fallback)
{
    const Json* value = find(key);
    if (!value) return fallback;
    if (!value->is_boolean()) fail(key, "true or false", described(*value));
    return value->get<bool>();
}

std::string ObjectReader::text(const std::string& key, const std::string& fallback)
{
    const Json* value = find(key);
    if (!value) return fallback;
    if (!value->is_string()) fail(key, "a text", described(*value));
    return value->get<std::string>();
}

std::string ObjectReader::beside(const std::string& key, const std::string& name,
                                 const std::string& otherwise) const
{
    namespace fs = std::filesystem;
    const fs::path plain = fs::path(name).lexically_normal();
    if (plain.empty() || plain.is_absolute() || *plain.begin() == "..")
        fail(key, "a path inside the document's folder" + otherwise,
             "\"" + name.substr(0, 200) + "\"");
    return (fs::path(path).parent_path() / plain).string();
}

Vec3<double> ObjectReader::vector(const std::string& key, Bounds each)
{
    const std::string expected = "three numbers, each " + described(each).substr(2);
    const Json& value = required(key, expected);
    if (!value.is_array() || value.size() != 3) fail(key, expected, described(value));
    const auto at = [&](int i) {
        return checked(value[std::size_t(i)], pointer(key) + "/" + std::to_string(i), each);
    };
    return {at(0), at(1), at(2)};
}

Vec3<double> ObjectReader::vector(const std::string& key, Bounds each, Vec3<double> fallback)
{
    return has(key) ? vector(key, each) : fallback;
}

std::size_t ObjectReader::chosen(const std::string& key, const std::vector<std::string>& names)
{
    const Json& value = *find(key);
    const std::string expected = "one of " + joined(names);
    if (!value.is_string()) fail(key, expected, described(value));
    const auto word = value.get<std::string>();
    const auto at = std::find(names.begin(), names.end(), word);
    if (at == names.end())
        fail(key, expected,
             described(value) + "; the nearest is \"" + nearest_name(word, names) + "\"");
    return std::size_t(at - names.begin());
}

void ObjectReader::object(const std::string& key, const Body& body)
{
    static const Json nothing = Json::object();
    const Json* value = find(key);
    read(value ? *value : nothing, path, pointer(key), body);
}

void ObjectReader::refuse_renamed(const std::string& old, const std::string& key) const
{
    if (object_value->contains(old))
        throw InputError(fmt::format("{}: {}: the key \"{}\" is called \"{}\" now", path,
                                     pointer(old), old, key));
}

std::vector<std::string> ObjectReader::unknown() const
{
    std::vector<std::string> left;
    for (const auto& [key, value] : object_value->items())
        if (std::find(known.begin(), known.end(), key) == known.end()) left.push_back(key);
    return left;
}

void ObjectReader::refuse_unknown() const
{
    const std::vector<std::string> left = unknown();
    if (left.empty()) return;
    throw InputError(fmt::format("{}: {}: unknown key \"{}\"; the nearest is \"{}\"", path,
                                 pointer(left[0]), left[0], nearest_name(left[0], known)));
}

}  // namespace knead
