#include "host/base/text_number.h"

#include <fast_float/fast_float.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>

#include "host/base/errors.h"

namespace knead {
namespace {

constexpr std::string_view no_number = "no number", comma = "decimal comma?";

// The rest of a word after its number: "#IND", "#QNAN", "#SNAN", "#INF" and what was cut of them by
// rounding to a width ("1.#J"), with digits after it.
bool is_old_special(std::string_view word)
{
    const std::size_t mark = word.find(".#");
    if (mark == std::string_view::npos || mark == 0 || mark + 2 == word.size()) return false;
    const std::string_view one = word.substr(0, mark);
    return one == "1" || one == "-1";
}

double old_special(std::string_view word)
{
    const bool infinite = word.find("INF") != std::string_view::npos;
    const double value = infinite ? std::numeric_limits<double>::infinity() : std::nan("");
    return word.front() == '-' ? -value : value;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "1,5" and "-,5": digits around a comma, and none but the one.
bool has_comma(std::string_view word)
{
    const std::size_t at = word.find(',');
    return at != std::string_view::npos && at + 1 < word.size() && is_digit(word[at + 1]) &&
           word.find_first_not_of("+-0123456789eE.,") == std::string_view::npos;
}

}  // namespace

TextNumber text_number(std::string_view word)
{
    const std::string_view whole = word;
    if (word.starts_with('+')) word.remove_prefix(1);
    if (word.empty() || word.front() == '+' || (whole.size() > word.size() && word.front() == '-'))
        return {0, no_number};
    if (is_old_special(word)) return {old_special(word), {}};
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto [at, problem] = fast_float::from_chars(word.data(), end, value);
    if (problem == std::errc::result_out_of_range && at == end)  // of newer versions
        return std::isinf(value) ? TextNumber{0, "too large"} : TextNumber{value, {}};
    if (problem != std::errc() || at != end) return {0, has_comma(whole) ? comma : no_number};
    const bool digits = std::ranges::any_of(word, is_digit);
    if (std::isinf(value) && digits) return {0, "too large"};
    return {value, {}};
}

TextNumber finite_text_number(std::string_view word)
{
    const TextNumber found = text_number(word);
    if (found.fault.empty() && !std::isfinite(found.value)) return {0, "not finite"};
    return found;
}

std::string in_brackets(std::string_view fault)
{
    return fault.empty() || fault == no_number ? "" : fmt::format(" ({})", fault);
}

std::size_t text_begin(std::string_view bytes, const std::string& path)
{
    using namespace std::string_view_literals;
    if (bytes.starts_with("\xef\xbb\xbf")) return 3;
    for (const std::string_view mark : {"\xff\xfe"sv, "\xfe\xff"sv, "\0\0\xfe\xff"sv})
        if (bytes.starts_with(mark))
            throw InputError(path + ": byte 0: expected text in UTF-8, found UTF-16 or UTF-32");
    return 0;
}

std::string_view next_line(std::string_view text, std::size_t& at)
{
    const std::size_t begin = at, end = std::min(text.find_first_of("\r\n", at), text.size());
    at = end + 1;
    if (end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n') ++at;
    at = std::min(at, text.size());
    return text.substr(begin, end - begin);
}

}  // namespace knead
