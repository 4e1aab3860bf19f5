// Files from outside, whole, into memory: the one door for everything that is read from a path. What has no end
// (devices, pipes) and what is too large is refused before memory is asked for.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lpe/budgets.h"

namespace raylex {

/// Who named a file. A person at a command line may name a pipe or a device, as shells do for `<(...)`: it is read up
/// to Budget::pipe_bytes. What a file names must be a regular file.
enum class NamedBy : std::uint8_t { file, command_line };

/// Reading stops, with an Error, soon after `flag` is set. For the whole program; nullptr: nothing stops it.
void stop_reading_when(const std::atomic<bool>* flag);
[[nodiscard]] bool reading_stopped();
[[nodiscard]] Error reading_stopped_error(const std::string& path);

/// Errors, naming `path`: no such file or not readable (`expected` says what was wanted: "a TOML job"), a directory, a
/// pipe, device or socket where none may be, more bytes than `most`. A UTF-8 byte order mark at the head is left out.
Result<std::string> read_input(const std::string& path, NamedBy by, const std::string& expected,
                               Budget most = Budget::text_bytes);

/// The same for a regular file that raylex keeps for itself, such as a study's records: a program that was stopped
/// still needs those to end in order, so that nothing stops it.
Result<std::string> read_record(const std::string& path, const std::string& expected,
                                Budget most = Budget::record_bytes);

/// The same questions without reading, for files that a library opens by itself: only a regular file passes.
Status check_regular_file(const std::string& path, const std::string& expected);

/// Takes a UTF-8 byte order mark off the head of `text`.
void drop_byte_order_mark(std::string& text);

}  // namespace raylex
