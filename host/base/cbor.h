// CBOR (RFC 8949) as JSON values.
#pragma once
#include <optional>
#include <string_view>

#include "host/base/json_reader.h"

namespace knead {

// None for bytes that are not exactly one value, or a value nested deeper than `levels`: the JSON
// library recurses once per level and would overflow the stack.
std::optional<Json> parse_cbor(std::string_view bytes, int levels = 8);

}  // namespace knead
