// The compiler against an independent matcher: the bytes choose tokens of an expression and the events of a path, and
// both must say the same (tests/lpe/oracle.h: its own parser, its own predicates, a matcher by positions).
#include "lpe/match.h"
#include "lpe/program.h"
#include "tests/fuzz/fuzz.h"
#include "tests/lpe/oracle.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    fuzz::Bytes bytes(data, size);
    const Dialect dialect = bytes.below(2) == 0 ? Dialect::renderman : Dialect::osl;
    oracle::Path path;
    for (std::size_t length = bytes.below(8); length > 0; --length) {
        path.push_back(oracle::alphabet()[bytes.below(oracle::alphabet().size())]);
    }
    std::vector<std::size_t> sequence;
    while (!bytes.empty() && sequence.size() < 40) { sequence.push_back(bytes.below(oracle::tokens(dialect).size())); }
    const auto tree = oracle::parse(sequence, dialect);
    ChannelSource source;
    source.expression = oracle::text_of(sequence, dialect);
    source.dialect = dialect;
    const auto program = Program::compile({&source, 1}, {.any_path_string = true});
    fuzz::require(tree != nullptr || !program.ok(), "what is no expression is refused: " + source.expression);
    if (!program) return 0;  // no expression, or one too large for lpe/limits.h
    State state = program->starts()[0];
    for (const Event& event : path) state = program->next(state, program->classify(event));
    fuzz::require(program->accepts_any(state) == oracle::matches(*tree, path, dialect),
                  source.expression + " on " + to_text(path));
    return 0;
}
