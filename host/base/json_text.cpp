// JSON from text, with the place of parser errors.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "host/base/json_reader.h"
#include "host/base/text_number.h"

namespace knead {
namespace {

constexpr int deepest = 64;  // levels; scenes need 4

std::string position(const std::string& text, std::size_t byte)
{
    const std::size_t end = std::min(byte, text.size());
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i < end; ++i) {
        ++column;
        if (text[i] == '\n') ++line, column = 1;
    }
    return fmt::format("line {}, column {} (byte {})", line, column, end);
}

// Iterator over a text that records its farthest position: the parser reports no position for
// numbers beyond the range of double.
struct Progressing {
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    const char* at;
    const char** farthest;

    reference operator*() const { return *at; }
    Progressing& operator++()
    {
        *farthest = ++at;
        return *this;
    }
    bool operator==(const Progressing& other) const { return at == other.at; }
};

// Index of the first character of the number that ends before `end`.
std::size_t number_before(const std::string& text, std::size_t end)
{
    while (end > 0 && std::strchr("+-.0123456789eE", text[end - 1])) --end;
    return end;
}

}  // namespace

Json parse_json(const std::string& text, const std::string& file)
{
    text_begin(text, file);  // the parser skips the mark of UTF-8
    std::vector<std::set<std::string>> keys;
    const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
        if (depth > deepest)
            throw InputError(
                fmt::format("{}: expected at most {} levels of nesting", file, deepest));
        if (event == Json::parse_event_t::object_start) {
            keys.resize(std::size_t(depth) + 1);
            keys.back().clear();
        }
        if (event == Json::parse_event_t::key) {
            const auto& key = parsed.get_ref<const std::string&>();
            if (!keys[std::size_t(depth) - 1].insert(key).second)
                throw InputError(
                    fmt::format("{}: key \"{}\" is given twice in one object", file, key));
        }
        return true;
    };
    const char *farthest = text.data(), *end = text.data() + text.size();
    try {
        return Json::parse(Progressing{text.data(), &farthest}, Progressing{end, &farthest}, watch,
                           true, true);
    } catch (const Json::parse_error& e) {
        std::string reason = e.what();
        const std::size_t tail = reason.rfind("; expected");
        reason = tail == std::string::npos ? "not JSON" : reason.substr(tail + 2);
        throw InputError(fmt::format("{}: {}: cannot be read as JSON: {}", file,
                                     position(text, e.byte), reason));
    } catch (const Json::out_of_range&) {
        // Unless the text ended, the parser has consumed one character beyond the number.
        auto last = std::size_t(farthest - text.data());
        if (last > 0 && !std::isdigit(static_cast<unsigned char>(text[last - 1]))) --last;
        const std::size_t first = number_before(text, last);
        throw InputError(fmt::format("{}: {}: expected a number within 1.8e308, found {}", file,
                                     position(text, first),
                                     text.substr(first, std::min<std::size_t>(last - first, 60))));
    } catch (const Json::exception& e) {
        throw InputError(fmt::format("{}: cannot be read as JSON: {}", file, e.what()));
    }
}

Json read_json(const std::string& file)
{
    return parse_json(read_text(file, max_json_bytes), file);
}

}  // namespace knead
