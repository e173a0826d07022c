#include "host/base/cbor.h"

#include <nlohmann/json.hpp>

namespace knead {
namespace {

// Rejects nesting deeper than `left` levels.
struct Depth : nlohmann::json_sax<Json> {
    int left;
    explicit Depth(int levels) : left(levels) {}
    bool down() { return --left >= 0; }
    bool up() { return ++left, true; }
    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool key(string_t&) override { return true; }
    bool start_object(std::size_t) override { return down(); }
    bool start_array(std::size_t) override { return down(); }
    bool end_object() override { return up(); }
    bool end_array() override { return up(); }
    bool parse_error(std::size_t, const std::string&, const Json::exception&) override
    {
        return false;
    }
};

}  // namespace

std::optional<Json> parse_cbor(std::string_view bytes, int levels)
{
    Depth depth(levels);
    if (!Json::sax_parse(bytes.begin(), bytes.end(), &depth, Json::input_format_t::cbor)) return {};
    Json value = Json::from_cbor(bytes.begin(), bytes.end(), true, false);
    if (value.is_discarded()) return {};
    return value;
}

}  // namespace knead
