#include "lpe/language/parser/parser.h"

#include <utility>

#include "lpe/failure.h"
#include "lpe/language/names.h"
#include "lpe/limits.h"

namespace raylex::lpe {

Expression parse(const ChannelSource& source, BarReading bar) {
    const SourceText text(source);
    if (text.size() > limits::text_bytes) {
        text.fail_at(limits::text_bytes, "the expression has " + std::to_string(text.size()) + " bytes; at most " +
                                             std::to_string(limits::text_bytes) + " are read");
    }
    if (source.dialect == Dialect::osl) { return parse_osl(text, bar); }
    Result<Expansion> expansion = expand_names(source);
    if (!expansion) { throw Failure{std::move(expansion).error()}; }
    Expression expression = parse_renderman(SourceText(expansion->source), bar);
    expression.warnings.insert(expression.warnings.begin(), expansion->warnings.begin(), expansion->warnings.end());
    return expression;
}

}  // namespace raylex::lpe
