// Compiled programs as files. A renderer that loads one does not compile, and does not link the compiler: load() and
// program_view.h are enough to follow paths.
//
// Format, version 1. All integers are little-endian on every machine. 8 bytes "RAYLEXPG", then u32 version, then the
// arrays of ProgramTables in the order of program_file.cpp, each as a u64 count and its elements; text is stored as
// bytes. The last 8 bytes are the 64-bit FNV-1a hash of all bytes before them. A reader refuses other versions.
//
// Reading checks the file: the hash detects damage, and every index is compared with the size of its array, so no file
// causes a read outside the arrays. Reading does not prove that a compiler wrote the content.
#pragma once

#include <string>
#include <string_view>

#include "lpe/program.h"
#include "lpe/result.h"

namespace raylex::lpe {

/// The program as the bytes of a file.
[[nodiscard]] std::string to_bytes(const Program& program);
/// Reads a program from the bytes that to_bytes() returns. `origin` names the bytes in errors. Errors: the bytes are
/// not a program, have another version, are cut short or damaged, or contain an index that is out of range.
Result<Program> program_from_bytes(std::string_view bytes, const std::string& origin);

/// Writes the program to a temporary file in the folder of `path`, then renames it. Errors: the file cannot be written.
Status save(const Program& program, const std::string& path);
Result<Program> load(const std::string& path);

}  // namespace raylex::lpe
