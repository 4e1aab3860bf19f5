// Parses text to a tree. lpe/README.md has the grammars.
#pragma once

#include "lpe/language/ast.h"
#include "lpe/language/source_text.h"
#include "lpe/program.h"

namespace raylex::lpe {

/// Parses in the source's dialect. Throws Failure with file, line and column.
[[nodiscard]] Expression parse(const ChannelSource& source, BarReading bar = BarReading::tight);

// One parser per dialect; parse() selects it.
[[nodiscard]] Expression parse_renderman(const SourceText& text, BarReading bar);
[[nodiscard]] Expression parse_osl(const SourceText& text, BarReading bar);

}  // namespace raylex::lpe
