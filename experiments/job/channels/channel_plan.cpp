#include "experiments/job/channels/channel_plan.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "experiments/job/channels/channel_reasons.h"
#include "experiments/job/channels/channel_set.h"
#include "experiments/job/channels/generated_channels.h"
#include "geoaovs/geoaovs.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/algebra/wording/regex_printing.h"
#include "lpe/language/names.h"

namespace raylex::experiments {
namespace {

using display::ChannelDefinition;
using display::ChannelStyle;

/// Returns a channel of light, in the dialect renderman.
ChannelDefinition expression_channel(std::string name, std::string expression) {
    ChannelDefinition channel;
    channel.name = std::move(name);
    channel.style = ChannelStyle::expression;
    channel.expression = std::move(expression);
    channel.space = "rendering colour space";
    return channel;
}

class Planner {
  public:
    Planner(const Job& job, const ScenePathStrings& scene) : job_(job), scene_(scene), words_(scene.words) {}

    Result<ChannelPlan> run() {
        for (const ExpressionRequest& request : job_.expressions) {
            Status added = add_expression(request);
            if (!added) return added.error();
        }
        for (Status (Planner::*step)() :
             {&Planner::declared_partitions, &Planner::automatic_rest, &Planner::shipped, &Planner::light_groups,
              &Planner::techniques, &Planner::declared, &Planner::aovs, &Planner::check_rules}) {
            Status done = (this->*step)();
            if (!done) return done.error();
            if (!plan_.refuted.empty()) break;
        }
        note_unexplained();
        return std::move(plan_);
    }

  private:
    Status add_channel(ChannelDefinition channel, const SourceLocation& where) {
        Status usable = check_layer_name(channel.name, where);
        if (!usable) return usable;
        if (const auto [known, is_new] = index_.emplace(channel.name, plan_.channels.size()); !is_new)
            return error_at(where,
                            "the channel name '" + channel.name +
                                "' is used twice with two meanings; expected every channel to have its own name",
                            "--rename " + channel.name + "=NAME renames the channel of a --channels file");
        plan_.channels.push_back(std::move(channel));
        sources_.emplace_back();
        return success();
    }

    /// Returns whether a channel of that name and meaning is already planned; both are then one layer.
    [[nodiscard]] bool is_there(const lpe::ChannelSource& source) const {
        const auto known = index_.find(source.name);
        return known != index_.end() && mean_the_same(sources_[known->second], source, job_.macros);
    }

    Status add_expression(const ExpressionRequest& request) {
        const SourceLocation& where = request.location;
        auto expansion = lpe::expand_names(
            {request.name, request.expression, request.dialect, where.file, where.line, where.column, {}, request.map},
            job_.macros);
        if (!expansion) return expansion.error();
        if (is_there(expansion->source)) return success();
        ChannelDefinition channel = expression_channel(request.name, expansion->source.expression);
        channel.dialect = request.dialect;
        channel.origin = where.file;
        channel.origin_line = where.line;
        channel.origin_column = where.column;
        Status added = add_channel(std::move(channel), request.location);
        if (!added) return added;
        for (const std::string& each : expansion->warnings)
            plan_.notes.push_back("channel '" + request.name + "': " + each);
        lpe::ChannelSource& source = sources_.back();
        source = std::move(expansion->source);
        auto prefixes = lpe::expression_prefixes(source);
        if (!prefixes) return prefixes.error();
        auto other = lpe::why_no_part(source);
        if (!other) return other.error();
        if (!other->empty()) no_part_[request.name] = *std::move(other);
        auto warnings = lpe::expression_warnings(source, words_);
        if (warnings)
            for (const std::string& each : *warnings) plan_.notes.push_back("channel '" + request.name + "': " + each);
        note_reach(source, std::find(prefixes->begin(), prefixes->end(), "holdouts") != prefixes->end());
        return success();
    }

    /// Notes a channel without paths. A job for another scene can have dozens of them, so only the first ones are
    /// explained.
    void note_black(const std::string& name, const std::string& reason) {
        constexpr int most_explained = 8;
        if (++black_ <= most_explained)
            plan_.notes.push_back("channel '" + name +
                                  "' matches no path of this scene, so its layer will be black: " + reason);
        else unexplained_.push_back(name);
    }
    void note_unexplained() {
        if (unexplained_.empty()) return;
        std::string names;
        for (const std::string& name : unexplained_) names += (names.empty() ? "'" : ", '") + name + "'";
        plan_.notes.push_back(std::to_string(unexplained_.size()) +
                              " more channels match no path of this scene, so their layers will be black: " + names +
                              "; raylex lpe explain EXPR --scene SCENE prints the reason");
    }

    /// Notes channels that will be black, with the reason, and records channels that equal the beauty.
    void note_reach(const lpe::ChannelSource& source, bool holdouts) {
        const std::string who = "channel '" + source.name + "'";
        const auto never = why_never(source, scene_);
        if (never && *never) note_black(source.name, **never);
        else if (holdouts && !scene_.holdouts)
            plan_.notes.push_back(who +
                                  " shows objects behind holdouts, and no object is a holdout, so its layer will be "
                                  "black; expected a [[label]] rule with holdout = true");
        const auto unknown = unknown_labels(source, scene_);
        if (unknown && !(never && *never))
            for (const std::string& each : *unknown) plan_.notes.push_back(who + ": " + each);
        const auto beauty = lpe::is_beauty(source, words_);
        if (beauty && *beauty && !rule_of(source.name)) plan_.beauties.push_back(source.name);
    }

    /// Adds a layer with all light that `channels` do not accept.
    Status add_rest(const std::string& name, const std::vector<std::string>& channels, const SourceLocation& where) {
        ChannelDefinition rest = expression_channel(name, rest_text(channels));
        for (const std::string& each : channels) rest.rest_of.push_back(index_.at(each));
        return add_channel(std::move(rest), where);
    }

    /// Returns an expression of the rest layer for its header, if there is a short one that holds in every scene or in
    /// this scene.
    [[nodiscard]] std::string rest_text(const std::vector<std::string>& channels) const {
        const std::vector<lpe::ChannelSource> sources = sources_of(channels);
        for (const lpe::PathStrings& words : {lpe::PathStrings{}, words_}) {
            auto text = lpe::rest_expression(sources, std::nullopt, words);
            if (text && *text) return **text;
        }
        return {};
    }

    [[nodiscard]] std::vector<lpe::ChannelSource> sources_of(const std::vector<std::string>& names) const {
        std::vector<lpe::ChannelSource> result;
        for (const std::string& name : names) result.push_back(sources_[index_.at(name)]);
        return result;
    }

    Status declared_partitions() {
        for (const PartitionRequest& request : job_.partitions) {
            for (const auto& known : plan_.partitions)
                if (known.name == request.name)
                    return error_at(request.location,
                                    "the partition name '" + request.name + "' is used twice; expected another name");
            std::vector<std::string> wanted = request.channels;
            if (!request.of.empty()) wanted.push_back(request.of);
            for (const std::string& name : wanted) {
                Status fits = check_member(request, name);
                if (!fits) return fits;
                in_partition_[name] = true;
            }
            if (request.of.empty() && !job_.settings.channels.beauty)
                return error_at(request.location, "partition '" + request.name +
                                                      "' splits the beauty, which this render does not have; expected "
                                                      "of = \"channel\", or no --no-beauty");
            if (!request.rest.empty() && !request.of.empty())
                return error_at(request.location,
                                "partition '" + request.name +
                                    "' has both 'of' and 'rest'; expected 'rest' only for a partition of the beauty");
            Status proved = prove(request);
            if (!proved || !plan_.refuted.empty()) return proved;
        }
        return success();
    }

    [[nodiscard]] const display::RuleRequest* rule_of(const std::string& name) const {
        for (const display::RuleRequest& request : job_.settings.channels.rules)
            if (request.channel == name && request.rule != display::FilterRule::filter) return &request;
        return nullptr;
    }

    Status check_member(const PartitionRequest& request, const std::string& name) const {
        const auto found = index_.find(name);
        if (found == index_.end()) {
            std::vector<std::string> known;
            std::string list;
            for (const ExpressionRequest& each : job_.expressions) {
                known.push_back(each.name);
                list += (list.empty() ? "" : ", ") + each.name;
            }
            return error_at(
                request.location,
                "partition '" + request.name + "' names the channel '" + name +
                    "', which does not exist; expected one of: " + (list.empty() ? "(no channel is declared)" : list),
                near_miss(name, known));
        }
        if (const auto other = no_part_.find(name); other != no_part_.end())
            return error_at(request.location, "channel '" + name + "' (" + other->second +
                                                  ") cannot be part of partition '" + request.name +
                                                  "'; expected plain expressions of light");
        return success();
    }

    Status prove(const PartitionRequest& request) {
        display::PartitionDeclaration declaration{request.name, request.of, request.channels};
        const std::vector<lpe::ChannelSource> sources = sources_of(request.channels);
        std::string summary;
        if (request.rest.empty()) {
            std::optional<lpe::ChannelSource> of;
            if (!request.of.empty()) of = sources_[index_.at(request.of)];
            auto report = lpe::check_partition(sources, of, words_);
            if (!report) return report.error();
            if (report->result != lpe::SplitProof::partition) summary = report->summary;
        } else {
            auto report = lpe::check_disjoint(sources, words_);
            if (!report) return report.error();
            if (!report->disjoint) summary = report->summary;
            Status added = add_rest(request.rest, request.channels, request.location);
            if (!added) return added;
            in_partition_[request.rest] = true;
            declaration.layers.push_back(request.rest);
        }
        if (!summary.empty()) {
            Error where = error_at(request.location, "partition '" + request.name + "' does not hold: " + summary);
            if (job_.measure_refuted) plan_.notes.push_back(where.to_string());
            else plan_.refuted = where.to_string();
        }
        plan_.partitions.push_back(std::move(declaration));
        return success();
    }

    /// Adds a `rest` layer for channels of the job that belong to no declared partition, if no path is in two of them.
    Status automatic_rest() {
        if (!job_.settings.channels.beauty) return success();
        std::vector<std::string> members;
        for (const ExpressionRequest& request : job_.expressions)
            if (!no_part_.contains(request.name) && !in_partition_.contains(request.name) && !rule_of(request.name) &&
                std::find(members.begin(), members.end(), request.name) == members.end())
                members.push_back(request.name);
        if (members.empty()) return success();
        auto report = lpe::check_disjoint(sources_of(members), words_);
        if (!report) {
            plan_.notes.push_back("no rest layer: " + report.error().message);
            return success();
        }
        if (!report->disjoint) {
            plan_.notes.push_back("no rest layer and no partition 'auto': " + report->summary);
            return success();
        }
        const std::string name = index_.contains("rest") ? "auto_rest" : "rest";
        Status added = add_rest(name, members, job_.expressions.front().location);
        if (!added) return added;
        members.push_back(name);
        plan_.partitions.push_back({"auto", "", std::move(members)});
        return success();
    }

    /// Adds a generated set of channels with its partition, which is proved like any other.
    Status add_generated(const std::string& partition, const std::vector<ExpressionRequest>& requests) {
        PartitionRequest declared;
        declared.name = partition;
        declared.location.file = "partition " + partition;
        for (const ExpressionRequest& request : requests) {
            declared.channels.push_back(request.name);
            lpe::ChannelSource source{
                request.name, request.expression, request.dialect, request.location.file, 0, 0, {}};
            if (is_there(source)) continue;
            ChannelDefinition channel = expression_channel(request.name, request.expression);
            channel.dialect = request.dialect;
            Status added = add_channel(std::move(channel), request.location);
            if (!added) return added;
            sources_.back() = std::move(source);
        }
        if (!job_.settings.channels.beauty) return success();  // no layer to sum to
        return prove(declared);
    }

    Status shipped() { return job_.shipped_partition ? add_generated("shipped", shipped_channels()) : success(); }

    Status light_groups() {
        return job_.light_groups ? add_generated("light_groups", light_group_channels(scene_.alphabet)) : success();
    }

    /// Adds the layers by technique of every requested channel, with their partition.
    Status techniques() {
        if (!job_.techniques) return success();
        const SourceLocation& where = job_.techniques->location;
        for (const std::string& name : job_.techniques->channels) {
            auto expression = technique_source(name);
            if (!expression) return expression.error();
            display::PartitionDeclaration partition{
                "techniques" + (name == "beauty" ? "" : "_" + name), name == "beauty" ? "" : name, {}};
            for (const TechniqueLayer& layer : technique_layers(words_.max_depth)) {
                ChannelDefinition channel =
                    expression_channel(name + "_" + layer.suffix, layer.prefix + ";" + *expression);
                channel.origin = where.file;
                channel.origin_line = where.line;
                if (layer.weighted) partition.layers.push_back(channel.name);
                if (Status added = add_channel(std::move(channel), where); !added) return added;
            }
            if (name != "beauty" || job_.settings.channels.beauty) plan_.partitions.push_back(std::move(partition));
        }
        return success();
    }

    /// Returns the expression of the channel that its layers by technique use after their prefix.
    [[nodiscard]] Result<std::string> technique_source(const std::string& name) const {
        if (name == "beauty") return std::string("C.*");
        const auto found = index_.find(name);
        const std::string requested = "layers of '" + name + "' by technique: ";
        if (found == index_.end() || plan_.channels[found->second].style != ChannelStyle::expression)
            return error_at(job_.techniques->location,
                            requested +
                                "no channel with a light path expression has this name; expected beauty or a "
                                "[[channel]] or --lpe channel of the job");
        const ChannelDefinition& channel = plan_.channels[found->second];
        if (channel.dialect != lpe::Dialect::renderman || !channel.rest_of.empty() || no_part_.contains(name))
            return error_at(
                job_.techniques->location,
                requested + "expected a channel in the renderman dialect, without prefixes and no rest layer");
        const std::string mark = "lpe:";
        return channel.expression.starts_with(mark) ? channel.expression.substr(mark.size()) : channel.expression;
    }

    Status declared() {
        for (const ChannelDefinition& channel : job_.declared)
            if (Status added = add_channel(channel, {channel.origin, channel.origin_line, channel.origin_column});
                !added)
                return added;
        return success();
    }

    Status aovs() {
        for (const AovRequest& request : job_.aovs) {
            auto definition = transport::named_channel(request.name, scene_.alphabet.pattern_channels);
            if (!definition) {
                Error error = definition.error();
                error.file = request.location.file;
                error.line = request.location.line;
                error.column = request.location.column;
                return error;
            }
            const auto known = index_.find(definition->name);
            const bool there = known != index_.end() && plan_.channels[known->second].style == definition->style &&
                               plan_.channels[known->second].expression == definition->expression;
            if (there) continue;
            Status added = add_channel(std::move(*definition), request.location);
            if (!added) return added;
        }
        return success();
    }

    /// Checks rules: layers of a rule that selects samples do not sum.
    Status check_rules() {
        for (const display::PartitionDeclaration& partition : plan_.partitions) {
            std::vector<std::string> members = partition.layers;
            members.push_back(partition.of);
            for (const std::string& name : members)
                if (const display::RuleRequest* rule = rule_of(name))
                    return error_at(rule->location, "channel '" + name + "' has the rule '" +
                                                        display::rule_name(rule->rule) +
                                                        "' and cannot be part of partition '" + partition.name +
                                                        "', whose layers sum only with the pixel filter");
        }
        return success();
    }

    const Job& job_;
    const ScenePathStrings& scene_;
    lpe::PathStrings words_;
    ChannelPlan plan_;
    std::vector<lpe::ChannelSource> sources_;  // parallel to plan_.channels
    std::map<std::string, std::size_t> index_;
    std::map<std::string, std::string> no_part_;  // channel -> why it cannot be part of a split: why_no_part()
    std::map<std::string, bool> in_partition_;
    int black_ = 0;  // number of channels without paths, and of those that have no note of their own
    std::vector<std::string> unexplained_;
};

}  // namespace

Result<ChannelPlan> plan_channels(const Job& job, const ScenePathStrings& scene) {
    return Planner(job, scene).run();
}

}  // namespace raylex::experiments
