// Any bytes as an expression, in both dialects: compiled, asked for its words and read aloud, or refused with a
// message. The first byte chooses the dialect and whether any word counts.
#include "lpe/algebra/proofs/check.h"
#include "lpe/match.h"
#include "lpe/program.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    fuzz::Bytes bytes(data, size);
    const std::size_t choice = bytes.below(4);
    ChannelSource source;
    source.name = "fuzzed";
    source.dialect = choice % 2 == 0 ? Dialect::renderman : Dialect::osl;
    source.expression = bytes.rest();
    const auto program = Program::compile({&source, 1}, {.any_path_string = choice >= 2});
    if (!program) {
        fuzz::require(!program.error().message.empty(), "a refusal says why");
        return 0;
    }
    fuzz::require(program->state_count() >= 1 && program->starts().size() <= 1, "one channel is at most one automaton");
    const auto word = find_path_string(source);
    if (word && word->has_value()) {
        const auto matches = match(source.expression, (*word)->events, source.dialect);
        fuzz::require(matches.ok() && *matches, "the shortest word is accepted");
    }
    return 0;
}
