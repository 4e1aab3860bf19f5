#include "lpe/algebra/proofs/paths.h"

#include <utility>

#include "lpe/algebra/proofs/question.h"
#include "lpe/algebra/proofs/samples.h"
#include "lpe/failure.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

/// The result of the operation, restricted to W.
Dfa made_of(Operation operation, const Languages& languages) {
    const std::vector<Dfa>& channels = languages.channels;
    const Dfa& words = *languages.words;
    Dfa result = operation == Operation::complement ? difference(words, channels[0]) : intersection(words, channels[0]);
    for (std::size_t k = 1; k < channels.size(); ++k) {
        switch (operation) {
            case Operation::intersection:
                result = intersection(result, channels[k]);
                break;
            case Operation::difference:
                result = difference(result, channels[k]);
                break;
            default:
                result =
                    required(product(result, intersection(words, channels[k]), union_of(), limits::boolean_states));
        }
    }
    return result;
}

}  // namespace

Result<PathSet> look_at_paths(Operation operation, std::span<const ChannelSource> channels, const PathStrings& words,
                              const PathSetOptions& options) {
    return guarded([&] {
        const bool single = operation == Operation::words || operation == Operation::complement;
        if (channels.empty() || (single && channels.size() > 1)) {
            fail(single ? "expected one channel" : "expected at least one channel");
        }
        const PathStrings cut = path_strings_for(channels, words);
        Question question = pose(channels, cut, nullptr, true);
        const Dfa paths = made_of(operation, question.languages);
        PathSet set;
        set.warnings = std::move(question.warnings);
        for (const auto& word : sample_path_strings(paths, options.samples)) {
            set.samples.push_back(witness_of(word, *question.languages.classes));
        }
        set.counts = count_path_strings(paths, options.longest_counted);
        set.longest = longest_path_string(paths);
        set.states = paths.states() - 1;
        return set;
    });
}

}  // namespace raylex::lpe
