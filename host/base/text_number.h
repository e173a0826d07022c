// Numbers, lines and encodings of text files that other programs wrote.
#pragma once
#include <string>
#include <string_view>

namespace knead {

struct TextNumber {
    double value = 0;
    std::string_view fault;  // "": `value` is what the whole word says; else why it says none
};
// The number that a word is, to the nearest double: with a leading plus, and below the range of
// double 0. "nan", "inf", "-nan(ind)" and MSVC's "1.#IND", "1.#QNAN", "1.#INF" are such values,
// which the caller refuses. Faults: "too large" for digits above the range, "decimal comma?" for
// "1,5", else "no number". Independent of the locale.
TextNumber text_number(std::string_view word);

// Of a finite number: as text_number(), with "not finite" as a further fault.
TextNumber finite_text_number(std::string_view word);

// " (decimal comma?)" for a message that ends with the word; "" for "no number".
std::string in_brackets(std::string_view fault);

// Where a text begins: after the byte order mark of UTF-8, if it has one. Throws InputError with
// `path` for the marks of UTF-16 and UTF-32.
std::size_t text_begin(std::string_view bytes, const std::string& path);

// The line at `at`, which ends with LF, CR LF, CR or the text; then `at` is the next one's begin.
std::string_view next_line(std::string_view text, std::size_t& at);

}  // namespace knead
