// Any bytes as an expression to be explained and drawn, and its shortest path to be doubted: sentences, notes, graph,
// the reason why a path does not match and, where none does, what was meant.
#include "experiments/job/channels/likely_mistakes.h"
#include "lpe/algebra/explanation/explain.h"
#include "lpe/algebra/explanation/why_not.h"
#include "lpe/algebra/graphs/graph.h"
#include "lpe/algebra/proofs/check.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex::lpe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter;
    fuzz::Bytes bytes(data, size);
    ChannelSource source;
    source.name = "fuzzed";
    source.dialect = bytes.below(2) == 0 ? Dialect::renderman : Dialect::osl;
    source.expression = bytes.rest();
    const auto explanation = explain(source);
    if (!explanation) {
        fuzz::require(!explanation.error().message.empty(), "a refusal says why");
        return 0;
    }
    fuzz::require(!explanation->sentence.empty(), "what is understood is said");
    for (const Witness& sample : explanation->samples) {
        const auto result = why_not(source, sample.events);
        fuzz::require(result.ok() && result->matches, "a sample matches: " + sample.text);
        if (sample.events.size() > 1) {
            const auto cut = why_not(source, {sample.events.data(), sample.events.size() - 1});
            fuzz::require(cut.ok() && (cut->matches || cut->live_events == sample.events.size() - 1),
                          "a sample without its end is a live prefix: " + sample.text);
        }
    }
    const auto word = find_path_string(source);
    if (word && !*word) static_cast<void>(raylex::experiments::likely_mistake(source, PathStrings()));
    const auto graph = graph_of({&source, 1});
    if (graph) fuzz::require(!to_dot(*graph).empty(), "a graph can be drawn");
    return 0;
}
