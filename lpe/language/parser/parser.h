// Text to tree. The grammars stand in lpe/README.md.
#pragma once

#include "lpe/language/ast.h"
#include "lpe/language/source_text.h"
#include "lpe/program.h"

namespace raylex::lpe {

/// Throws Failure with file, line and column.
[[nodiscard]] Expression parse(const ChannelSource& source, BarReading bar = BarReading::tight);

// One per dialect; `parse` chooses.
[[nodiscard]] Expression parse_renderman(const SourceText& text, BarReading bar);
[[nodiscard]] Expression parse_osl(const SourceText& text, BarReading bar);

}  // namespace raylex::lpe
