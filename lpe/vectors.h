// Conformance vectors: files of rows EXPRESSION<TAB>EVENTS<TAB>EXPECTED, '#' starting a comment line.
// EXPECTED is 1 (matches), 0 (does not), ERR (must be refused with a message) or NOCRASH (may be accepted or refused).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "lpe/event.h"
#include "lpe/result.h"

namespace raylex::lpe {

struct VectorRow {
    int line = 0;  ///< in the file, from 1
    std::string expression, events;
    std::string expected;  ///< as in the file
    std::string found;     ///< "1", "0" or "ERR"
    std::string message;   ///< why the expression was refused, when it was
};

struct VectorReport {
    std::size_t agree = 0;
    std::vector<VectorRow> disagree;
};

/// Runs every row of the file. Errors: unreadable file, a row without three fields, events or a verdict that do not
/// read (with file, line and column); a row whose expression is refused is no error but has found "ERR".
Result<VectorReport> run_vectors(const std::string& path, Dialect dialect);
/// The same on text; `origin` names it in errors.
Result<VectorReport> run_vectors_text(std::string_view text, const std::string& origin, Dialect dialect);

}  // namespace raylex::lpe
