// Files of tracked hands: a binary form (.hands) and an equivalent form in JSON lines (.jsonl).
// Both hold unfiltered poses; the byte layout is in docs/reference/recordings.md.
#pragma once
#include <string>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// Reads either form, detected from the content. Returns a recording that passes check(), or throws
// InputError with path, byte offset or line, expected and found.
Recording read_recording(const std::string& path);

// Writes the form given by the file extension, atomically. Throws InputError for another extension
// or a recording that check() rejects, OutputError if writing fails.
void write_recording(const std::string& path, const Recording& recording);

// The two forms in memory. Precondition: the recording passes check(). `path` is used in error
// messages only.
std::string to_binary(const Recording& recording);
std::string to_lines(const Recording& recording);
Recording from_bytes(const std::string& bytes, const std::string& path);

// Throws InputError unless the recording has a printable name, a rate, at least one frame,
// increasing times, finite poses within range, unit quaternions and radii >= 0. A joint that is not
// valid may also have an all-zero quaternion: never tracked.
void check(const Recording& recording);

}  // namespace knead
