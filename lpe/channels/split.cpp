#include "lpe/channels/split.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/channels/split_bins.h"
#include "lpe/failure.h"
#include "lpe/language/names.h"
#include "lpe/language/source_text.h"
#include "lpe/shipped.h"

namespace raylex::lpe {

namespace {

constexpr std::array<std::string_view, 5> axis_names{"light-group", "lobe", "bounce", "object", "terminal"};
constexpr std::size_t most_channels = 16'384;
constexpr std::size_t longest_name = 128;  // of a layer

template <class T>
T required(Result<T> result) {
    if (!result) { throw Failure{std::move(result).error()}; }
    return *std::move(result);
}

/// An expression for exactly `count` scattering events of any kind, or at least `count`, before the terminal.
std::string any_events(int count, bool open_ended, Dialect dialect) {
    if (dialect == Dialect::osl) {
        // Pass-through events can occur anywhere and do not affect the bin.
        std::string text;
        if (count > 0) { text = "([DGSV]<Ts>*)" + (count > 1 ? "{" + std::to_string(count) + "}" : std::string()); }
        return text + (open_ended ? "[DGSsV]*" : "");
    }
    if (open_ended) { return count == 0 ? ".*" : count == 1 ? ".+" : ".{" + std::to_string(count) + ",}"; }
    return count < 3 ? std::string(static_cast<std::size_t>(count), '.') : ".{" + std::to_string(count) + "}";
}

class Generator {
  public:
    explicit Generator(const SplitRequest& request) : request_(request) {}

    Split run() {
        check_axes();
        find_whole();
        const bool scattering = has_axis(request_, SplitAxis::lobe) || has_axis(request_, SplitAxis::object) ||
                                has_axis(request_, SplitAxis::bounce);
        const std::vector<TerminalBin> terminals = terminal_bins(request_);
        const std::vector<FirstBin> firsts = first_bins(request_);
        const std::vector<BounceBin> bounces = bounce_bins(request_);
        const std::string camera = request_.dialect == Dialect::osl ? "C<Ts>*" : "C";
        for (const TerminalBin& terminal : terminals) {
            if (!scattering) {
                add(terminal, {}, {}, "", "C" + any_events(0, true, request_.dialect) + terminal.text);
                continue;
            }
            add(terminal, {}, {}, request_.visible, camera + terminal.text);
            for (const FirstBin& first : firsts) {
                for (const BounceBin& bounce : bounces) {
                    const std::string straight =
                        request_.dialect == Dialect::osl && !(bounce.least == 1 && bounce.open_ended) ? "<Ts>*" : "";
                    add(terminal, first, bounce, "",
                        camera + first.text + straight +
                            any_events(bounce.least - 1, bounce.open_ended, request_.dialect) + terminal.text);
                }
            }
            for (std::size_t k = 0; firsts.empty() && k < bounces.size(); ++k) {
                add(terminal, {}, bounces[k], "",
                    camera + any_events(bounces[k].least, bounces[k].open_ended, request_.dialect) + terminal.text);
            }
        }
        prove();
        return std::move(split_);
    }

  private:
    void check_axes() {
        if (request_.by.empty()) {
            fail("the split has no axis; expected one or more of light-group, lobe, bounce, object and terminal");
        }
        for (auto axis = request_.by.begin(); axis != request_.by.end(); ++axis) {
            if (std::find(axis + 1, request_.by.end(), *axis) != request_.by.end()) {
                fail("the axis " + std::string(axis_names[static_cast<std::size_t>(*axis)]) +
                     " is named twice; expected it once");
            }
        }
    }

    /// Finds what is split. If it is less than the beauty, every channel is intersected with it.
    void find_whole() {
        if (!request_.of) { return; }
        const ChannelSource of = required(expand_names(*request_.of)).source;
        const std::vector<std::string> prefixes = required(expression_prefixes(of));
        if (!prefixes.empty()) {
            Error error;
            error.message = "the expression to split carries the prefix '" + prefixes.front() +
                            "', which changes the splatted value; expected a "
                            "plain expression";
            throw Failure{SourceText::whole_error(of, std::move(error))};
        }
        ChannelSource beauty;
        beauty.expression = beauty_expression(request_.dialect);
        beauty.dialect = request_.dialect;
        if (!required(find_difference(of, beauty, request_.words))) { return; }
        if (request_.dialect == Dialect::osl || of.dialect == Dialect::osl) {
            fail("osl has no operator that restricts a split to '" + of.expression +
                 "'; expected --dialect renderman, or the whole beauty");
        }
        const std::size_t mark = of.expression.find("lpe:");
        whole_ = of.expression.substr(mark == std::string::npos ? 0 : mark + 4);
        if (whole_.find('#') != std::string::npos) {
            whole_ += '\n';  // otherwise a comment at the end would include the parenthesis
        }
        split_.of = of;
        split_.of->expression = whole_;
        split_.of->map = nullptr;
    }

    void add(const TerminalBin& terminal, const FirstBin& first, const BounceBin& bounce, const std::string& visible,
             std::string text) {
        std::string name = request_.prefix;
        bool shown = false;
        for (const SplitAxis axis : request_.by) {
            std::string part;
            switch (axis) {
                case SplitAxis::light_group:
                    part = terminal.group;
                    break;
                case SplitAxis::terminal:
                    part = terminal.terminal;
                    break;
                case SplitAxis::lobe:
                    part = first.lobe;
                    break;
                case SplitAxis::object:
                    part = first.object;
                    break;
                case SplitAxis::bounce:
                    part = bounce.name;
                    break;
            }
            const bool of_scattering = axis != SplitAxis::light_group && axis != SplitAxis::terminal;
            if (of_scattering && !visible.empty()) {
                part = shown ? "" : visible;
                shown = true;
            }
            if (!part.empty()) { name += (name.empty() || name == request_.prefix ? "" : "_") + part; }
        }
        ChannelSource channel;
        channel.name = layer_name(std::move(name));
        channel.dialect = request_.dialect;
        channel.expression = whole_.empty() ? std::move(text) : text + "&(" + whole_ + ")";
        if (split_.channels.size() >= most_channels) {
            fail("the split has more than " + std::to_string(most_channels) + " channels; expected fewer bins");
        }
        const bool may_be_empty = !whole_.empty() || request_.words.alphabet.has_value();
        if (may_be_empty && !required(find_path_string(channel, request_.words))) {
            empty_.push_back(std::move(channel.name));
            return;
        }
        split_.channels.push_back(std::move(channel));
    }

    /// A valid layer name: it begins with a letter or _, is not a name of the beauty, and is unique.
    std::string layer_name(std::string name) {
        if (name.empty() || (name.front() >= '0' && name.front() <= '9') || name.front() == '-') {
            name.insert(0, "_");
        }
        for (const char* reserved : {"beauty", "rgba", "R", "G", "B", "A", "Y"}) {
            if (name == reserved) { name += "_"; }
        }
        if (name.size() > longest_name) {
            fail("the name '" + name + "' has " + std::to_string(name.size()) + " bytes; a layer's has at most " +
                     std::to_string(longest_name),
                 "split by fewer axes, or give the lobes short names: coat=S4");
        }
        const std::string stem = name;
        for (int k = 2; !names_.insert(name).second; ++k) { name = stem + "_" + std::to_string(k); }
        return name;
    }

    void prove() {
        PartitionReport report = required(check_partition(split_.channels, split_.of, request_.words));
        if (report.result != SplitProof::partition) {
            fail("this split is not a partition: " + report.summary,
                 "a label that equals a letter of the dialect causes this");
        }
        split_.summary = std::move(report.summary);
        if (!empty_.empty()) {
            split_.notes.push_back(
                "no path reaches " +
                (empty_.size() == 1 ? std::string("this bin") : std::to_string(empty_.size()) + " bins") +
                ", left out: " + joined_by(empty_, ", "));
        }
    }

    const SplitRequest& request_;
    Split split_;
    std::string whole_;
    std::set<std::string> names_;
    std::vector<std::string> empty_;  // names of the bins that are left out
};

}  // namespace

Result<SplitAxis> parse_split_axis(std::string_view text) {
    for (std::size_t k = 0; k < axis_names.size(); ++k) {
        if (axis_names[k] == text) { return static_cast<SplitAxis>(k); }
    }
    Error error;
    error.message = "unknown axis '" + std::string(text) + "'; expected light-group, lobe, bounce, object or terminal";
    const std::string near = nearest(text, axis_names.data(), axis_names.size());
    error.hint = near.empty() ? "" : "did you mean '" + near + "'?";
    return error;
}

SplitRequest compositing_split(std::vector<std::string> groups, Dialect dialect, PathStrings words) {
    SplitRequest request;
    request.by = {SplitAxis::light_group, SplitAxis::bounce, SplitAxis::lobe};
    request.groups = std::move(groups);
    // Without a group, all lights are in the bin `default`; an axis without names is an error.
    request.groups.emplace_back("default");
    const std::string specular = dialect == Dialect::osl ? "[GS]" : "S";
    request.lobes = {"diffuse=RD", "specular=R" + specular, "transmission=T" + specular, "subsurface=TD"};
    if (words.volume) { request.lobes.emplace_back("volume=V"); }
    request.bounces = 2;
    request.visible = "emission";
    request.dialect = dialect;
    request.words = std::move(words);
    return request;
}

Result<Split> generate_split(const SplitRequest& request) {
    return guarded([&] { return Generator(request).run(); });
}

}  // namespace raylex::lpe
