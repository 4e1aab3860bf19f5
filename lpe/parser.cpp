#include "lpe/parser.h"

#include "lpe/limits.h"

namespace raylex::lpe {

Expression parse(const ChannelSource& source, BarReading bar) {
    const SourceText text(source);
    if (text.size() > limits::text_bytes) {
        text.fail_at(limits::text_bytes, "the expression has " + std::to_string(text.size()) + " bytes; at most " +
                                             std::to_string(limits::text_bytes) + " are read");
    }
    return source.dialect == Dialect::osl ? parse_osl(text, bar) : parse_renderman(text, bar);
}

}  // namespace raylex::lpe
