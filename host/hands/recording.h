// Files of tracked hands: a binary form (.hands) and its twin in JSON lines (.jsonl). Both hold the
// unfiltered poses; docs/reference/recordings.md lays them out byte by byte.
#pragma once
#include <string>

#include "host/base/errors.h"
#include "host/hands/hands.h"

namespace knead {

// Reads either form, told apart by content. Whatever the file holds, the answer is a recording that
// passes check() or an InputError with path, byte offset or line, what was expected and found.
Recording read_recording(const std::string& path);

// The form is chosen by the ending; the file appears whole or not at all. Throws InputError for
// another ending or a recording that check() refuses, OutputError where the disk refuses.
void write_recording(const std::string& path, const Recording& recording);

// The two forms in memory, of a recording that passes check(); `path` is only for error texts.
std::string to_binary(const Recording& recording);
std::string to_lines(const Recording& recording);
Recording from_bytes(const std::string& bytes, const std::string& path);

// Throws InputError unless the recording has a printable name, a rate, at least one frame, rising
// times, finite poses in reach, unit quaternions and radii >= 0. A joint that is not valid may also
// have an all-zero quaternion: it has never been seen.
void check(const Recording& recording);

}  // namespace knead
