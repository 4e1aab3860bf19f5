// The bins of each axis of a split, as pieces of expressions: first scattering events, bounces, terminals.
#pragma once

#include <string>
#include <vector>

#include "lpe/channels/split.h"

namespace raylex::lpe {

struct FirstBin {
    std::string lobe, object;  ///< names of the bins; empty where the split has no such axis
    std::string text;          ///< one item: the first scattering event
};

struct BounceBin {
    std::string name;
    int least = 1;  ///< scattering events
    bool open_ended = false;
};

struct TerminalBin {
    std::string group, terminal;  ///< names of the bins
    std::string text;
};

[[nodiscard]] bool has_axis(const SplitRequest& request, SplitAxis axis);

// Each throws Failure.
[[nodiscard]] std::vector<FirstBin> first_bins(const SplitRequest& request);
[[nodiscard]] std::vector<BounceBin> bounce_bins(const SplitRequest& request);
[[nodiscard]] std::vector<TerminalBin> terminal_bins(const SplitRequest& request);

/// Letters, digits, _ and - in place of other bytes; unlike every name in `taken`, to which it is added.
[[nodiscard]] std::string bin_name(const std::string& label, std::vector<std::string>& taken);

/// 'key', and 'key''fill' for a list of labels.
[[nodiscard]] std::string label_text(const std::string& label, Dialect dialect);
[[nodiscard]] std::string quoted_list(const std::vector<std::string>& labels, Dialect dialect = Dialect::renderman);
/// The names of an axis, each once. Throws Failure when there are none; `option` says how to give them.
[[nodiscard]] std::vector<std::string> unique_names(const std::vector<std::string>& list, const char* axis,
                                                    const char* option);

}  // namespace raylex::lpe
