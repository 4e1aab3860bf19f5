#include <algorithm>

#include "experiments/study/analysis/bias.h"
#include "lpe/algebra/proofs/paths.h"

namespace raylex::experiments {
namespace {

lpe::ChannelSource source_of(const TestedChannel& channel) {
    lpe::ChannelSource source;
    source.name = channel.name;
    source.expression = channel.expression;
    source.dialect = channel.dialect == "osl" ? lpe::Dialect::osl : lpe::Dialect::renderman;
    source.origin = "channel '" + channel.name + "'";
    return source;
}

Counterexamples::Counterexample counterexample_of(const TestedChannel& channel, const lpe::Witness& witness) {
    return {channel.name, witness.text, witness.sentence, witness.events.size(), channel.adjusted_p};
}

}  // namespace

Counterexamples find_counterexamples(std::span<const TestedChannel> channels, const lpe::PathStrings& words) {
    Counterexamples result;
    std::vector<lpe::ChannelSource> clean;
    for (const TestedChannel& channel : channels)
        if (!channel.differs && !channel.expression.empty()) clean.push_back(source_of(channel));
    for (const TestedChannel& channel : channels) {
        if (!channel.differs || channel.expression.empty()) continue;
        std::vector<lpe::ChannelSource> asked{source_of(channel)};
        asked.insert(asked.end(), clean.begin(), clean.end());
        lpe::PathSetOptions options;
        options.samples = 1;
        options.longest_counted = 0;
        Result<lpe::PathSet> outside = lpe::look_at_paths(lpe::Operation::difference, asked, words, options);
        if (outside && !outside->empty()) {
            result.words.push_back(counterexample_of(channel, outside->samples.front()));
            continue;
        }
        // All its paths are in channels without a difference, whose error may be too small to detect, so its own
        // shortest word is the best guess.
        Result<std::optional<lpe::Witness>> own = lpe::find_path_string(asked.front(), words);
        if (!own) result.notes.push_back(own.error().to_string());
        else if (!*own)
            result.notes.push_back("channel '" + channel.name + "' differs, although no path of the scene is in it");
        else result.words.push_back(counterexample_of(channel, **own));
    }
    std::stable_sort(result.words.begin(), result.words.end(), [](const auto& a, const auto& b) {
        return a.events != b.events ? a.events < b.events : a.adjusted_p < b.adjusted_p;
    });
    return result;
}

}  // namespace raylex::experiments
