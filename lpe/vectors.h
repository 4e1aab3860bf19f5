// Conformance vectors: files of rows EXPRESSION<TAB>EVENTS<TAB>EXPECTED; '#' starts a comment line.
// EXPECTED is 1 (matches), 0 (does not), ERR (must be refused with a message) or NOCRASH (either is allowed).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct VectorRow {
    int line = 0;  ///< line in the file, from 1
    std::string expression, events;
    std::string expected;  ///< as in the file
    std::string found;     ///< "1", "0" or "ERR"
    std::string message;   ///< the error message if the expression was refused
};

struct VectorReport {
    std::size_t agree = 0;
    std::vector<VectorRow> disagree;
};

/// Runs every row of the file. Errors: an unreadable file, a row without three fields, events or an expected result
/// that do not parse (with file, line and column). A row whose expression is refused is not an error; its `found` is
/// "ERR".
Result<VectorReport> run_vectors(const std::string& path, Dialect dialect);
/// Runs rows from a text; `origin` names the text in errors.
Result<VectorReport> run_vectors_text(std::string_view text, const std::string& origin, Dialect dialect);

}  // namespace raylex::lpe
