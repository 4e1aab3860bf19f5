// Reads whole external files into memory. Everything that is read from a path uses this. Endless inputs (devices,
// pipes) and inputs that are too large are refused before memory is allocated.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lpe/input/budgets.h"

namespace raylex {

/// How a file was named. On the command line a person can name a pipe or a device, as shells do for `<(...)`; at most
/// Budget::pipe_bytes are read. A file that another file names must be a regular file.
enum class NamedBy : std::uint8_t { file, command_line };

/// Makes all reading in the program stop with an Error soon after `flag` is set; nullptr: never.
void stop_reading_when(const std::atomic<bool>* flag);
[[nodiscard]] bool reading_stopped();
[[nodiscard]] Error reading_stopped_error(const std::string& path);

/// Reads a file without a leading UTF-8 byte order mark. Errors, which name `path`: the file does not exist or is not
/// readable (`expected` describes the required content: "a TOML job"); it is a directory, or a pipe, device or socket
/// where none is allowed; it has more bytes than the budget `most`.
Result<std::string> read_input(const std::string& path, NamedBy by, const std::string& expected,
                               Budget most = Budget::text_bytes);

/// Reads a regular file that raylex maintains, such as a study's records. stop_reading_when() does not apply, because a
/// stopped program still needs these files to end in order.
Result<std::string> read_record(const std::string& path, const std::string& expected,
                                Budget most = Budget::record_bytes);

/// Checks, without reading, a file that a library opens itself: it must be a regular file.
Status check_regular_file(const std::string& path, const std::string& expected);

/// Removes a UTF-8 byte order mark from the beginning of `text`.
void drop_byte_order_mark(std::string& text);

}  // namespace raylex
