// Commands as JSON, and logs of commands: one line each, {"frame": N, "NAME": {...}}.
// docs/reference/commands.md.
#pragma once
#include <string>
#include <vector>

#include "host/base/json_reader.h"
#include "host/document/command.h"

namespace knead {

constexpr std::size_t most_commands = 1000000;     // in a log
constexpr std::size_t max_log_bytes = 256u << 20;  // of its file

// A command, and the frame after which it is applied; 0: before the first.
struct LoggedCommand {
    long frame = 0;
    Command command;
    int line = 0;  // of the file it was read from; 0: of none
};

// A log: the contents of its first line, if it has one, and the commands in order of frames.
struct CommandLog {
    std::string scene;                  // file, as given; "": not given
    std::vector<std::string> settings;  // --set, as given
    std::string recording;              // hash of the recording's file; "": of none
    std::vector<LoggedCommand> commands;
};

// {"NAME": {...}}; values are written to the bit.
Json json_of(const Command& command);
// Reads what json_of() writes. `pointer`: place of `value` in `file`, for messages. `folder`: of
// the files that the command gives by a relative path. Throws InputError with the field.
Command read_command(const Json& value, const std::string& file, const std::string& pointer,
                     const std::string& folder);

// Throw InputError with file and line.
CommandLog parse_command_log(const std::string& text, const std::string& file,
                             const std::string& folder);
CommandLog read_command_log(const std::string& file, const std::string& folder);

std::string line_of(const LoggedCommand& logged);  // with a line's end
std::string to_text(const CommandLog& log);        // first a line with `scene` etc., if not empty
void write_command_log(const std::string& file, const CommandLog& log);  // throws OutputError

// The log beside a recording: its name and ".commands".
std::string command_log_of(const std::string& recording);

}  // namespace knead
