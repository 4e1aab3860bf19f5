// The bins of each axis of a split, as parts of expressions: first scattering events, bounces, terminals.
#pragma once

#include <string>
#include <vector>

#include "lpe/channels/split.h"

namespace raylex::lpe {

struct FirstBin {
    std::string lobe, object;  ///< names of the bins; empty where the split lacks the axis
    std::string text;          ///< one item that matches the first scattering event
};

struct BounceBin {
    std::string name;
    int least = 1;  ///< smallest number of scattering events
    bool open_ended = false;
};

struct TerminalBin {
    std::string group, terminal;  ///< names of the bins
    std::string text;
};

[[nodiscard]] bool has_axis(const SplitRequest& request, SplitAxis axis);

// The bins of each axis. Each function throws Failure.
[[nodiscard]] std::vector<FirstBin> first_bins(const SplitRequest& request);
[[nodiscard]] std::vector<BounceBin> bounce_bins(const SplitRequest& request);
[[nodiscard]] std::vector<TerminalBin> terminal_bins(const SplitRequest& request);

/// Replaces bytes other than letters, digits, _ and -, and makes the name unique in `taken`, to which it is added.
[[nodiscard]] std::string bin_name(const std::string& label, std::vector<std::string>& taken);

/// One label in quotes: 'key'. quoted_list() writes several: 'key''fill'.
[[nodiscard]] std::string label_text(const std::string& label, Dialect dialect);
[[nodiscard]] std::string quoted_list(const std::vector<std::string>& labels, Dialect dialect = Dialect::renderman);
/// The distinct names of an axis. Throws Failure when there are none; `option` is the option that sets them.
[[nodiscard]] std::vector<std::string> unique_names(const std::vector<std::string>& list, const char* axis,
                                                    const char* option);

}  // namespace raylex::lpe
