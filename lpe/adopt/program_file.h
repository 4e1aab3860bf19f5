// A compiled program as a file, so that a renderer need not compile, or need not even link the compiler: load() and
// program_view.h are enough to follow paths.
//
// Format, version 1. All integers are little-endian whatever the machine. 8 bytes "RAYLEXPG", then u32 version, then
// the arrays of ProgramTables in the order of program_file.cpp, each as u64 count and its elements; text as bytes. The
// last 8 bytes are the FNV-1a hash (64 bits) of all before them. A reader refuses other versions.
//
// A file is checked when it is read: its hash tells damage, and every index in it is compared with the array it goes
// into, so that no file, however made, leads to a read outside the arrays. What the file says is not proved to be what
// any compiler would write.
#pragma once

#include <string>
#include <string_view>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// The bytes of a file.
[[nodiscard]] std::string to_bytes(const Program& program);
/// The inverse. `origin` names the bytes in errors. Errors: not a program, another version, cut short, damaged, or an
/// index that leads nowhere.
Result<Program> program_from_bytes(std::string_view bytes, const std::string& origin);

/// Writes to a temporary name beside `path` and renames. Errors: the file cannot be written.
Status save(const Program& program, const std::string& path);
Result<Program> load(const std::string& path);

}  // namespace raylex::lpe
