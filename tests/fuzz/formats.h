// The formats that fuzzing reads: valid inputs of each by the program's own writers, and what is
// done with the bytes of one.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "host/base/errors.h"

namespace knead {

struct FuzzFormat {
    const char* name;
    // Whole files, as different as the format allows.
    std::vector<std::string> (*seeds)();
    // Reads the bytes, and does with them what the program does. Throws InputError where they are
    // refused; anything else that is thrown is a fault of the program. Files with a checksum are
    // read a second time with the right one: no change of theirs would come past it otherwise.
    void (*read)(const std::string& bytes);
};
const std::vector<FuzzFormat>& fuzz_formats();

// What was read is written, and that is read again: here a refusal is a fault of ours.
template <class Action>
void must_pass(const char* what, Action&& action)
{
    try {
        action();
    } catch (const InputError& e) {
        throw std::logic_error(std::string(what) + ": " + e.what());
    }
}

// Of fuzz_formats(), by the file that they are in.
std::vector<FuzzFormat> mesh_formats();     // mesh_formats.cpp
std::vector<FuzzFormat> cloud_formats();    // cloud_formats.cpp: particles and splats
std::vector<FuzzFormat> session_formats();  // session_formats.cpp: scenes, hands, reports, ...

}  // namespace knead
