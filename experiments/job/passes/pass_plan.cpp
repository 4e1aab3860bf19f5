#include "experiments/job/passes/pass_plan.h"

#include <algorithm>
#include <set>
#include <utility>

#include "experiments/job/channels/generated_channels.h"
#include "experiments/job/passes/pass_classes.h"
#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/event_words.h"
#include "lpe/language/names.h"
#include "transport/integrators/integrator.h"
#include "transport/render/tiles.h"
#include "transport/scene/sampler.h"

namespace raylex::experiments {
namespace {

using display::ChannelDefinition;
using display::ChannelStyle;

class PassPlanner {
  public:
    PassPlanner(const Job& job, const transport::SceneDescription& scene, const ScenePathStrings& words,
                ChannelPlan& channels)
        : job_(job), scene_(scene), words_(words), channels_(channels) {}

    Result<PassPlan> run() {
        for (Status (PassPlanner::*step)() :
             {&PassPlanner::find_classes, &PassPlanner::prove, &PassPlanner::check_methods, &PassPlanner::drop_empty,
              &PassPlanner::join, &PassPlanner::plan_halves, &PassPlanner::add_layers,
              &PassPlanner::restrict_channels}) {
            if (Status done = (this->*step)(); !done) return done.error();
            if (!plan_.refuted.empty()) break;
        }
        return std::move(plan_);
    }

  private:
    Status find_classes() {
        std::set<std::string> names;
        double shares = 0;
        for (const PassRequest& request : job_.passes) shares += request.time_share;
        for (std::size_t i = 0; i < job_.passes.size(); ++i) {
            const PassRequest& request = job_.passes[i];
            PlannedPass pass;
            pass.name = request.name.empty() ? request.method.type : request.name;
            for (int number = 2; !names.insert(pass.name).second; ++number)
                pass.name = (request.name.empty() ? request.method.type : request.name) + "_" + std::to_string(number);
            pass.method = transport::integrator_for(request.method, scene_.integrator);
            pass.takes = request.takes;
            pass.samples_per_pixel = request.samples_per_pixel;
            pass.time_share = request.time_share / shares;
            pass.has_aovs = request.has_aovs;
            if (request.takes == "rest") {
                if (rest_) return error_at(request.location, "two passes take the rest; expected at most one");
                rest_ = i;
            } else {
                auto expression = class_of(request);
                if (!expression) return expression.error();
                pass.expression = *std::move(expression);
            }
            plan_.passes.push_back(std::move(pass));
        }
        if (rest_) {
            std::vector<std::string> others;
            for (const PlannedPass& pass : plan_.passes)
                if (!pass.expression.empty()) others.push_back(pass.expression);
            plan_.passes[*rest_].expression = paths_without("C.*", others);
        }
        return check_traits();
    }

    /// Returns the expression of what a pass takes: a layer, a light group, or an expression.
    [[nodiscard]] Result<std::string> class_of(const PassRequest& request) {
        const std::string who = "the pass '" + request.method.type + "' takes '" + request.takes + "', ";
        for (const ChannelDefinition& channel : channels_.channels) {
            if (channel.name != request.takes || channel.style != ChannelStyle::expression) continue;
            if (!channel.rest_of.empty())
                return error_at(request.location, who + "which is the rest of other layers",
                                "expected takes = \"rest\" for all paths that no other pass takes");
            return checked(request, who, {channel.name, channel.expression, channel.dialect});
        }
        const std::vector<std::string>& groups = words_.alphabet.light_groups;
        const std::vector<ExpressionRequest> of_groups = light_group_channels(words_.alphabet);
        std::size_t next = 0;
        for (const std::string& group : groups) {
            if (group.empty()) continue;
            if (group == request.takes) return of_groups[next].expression;
            ++next;
        }
        lpe::ChannelSource source{request.takes,         request.takes,         lpe::Dialect::renderman,
                                  request.location.file, request.location.line, request.location.column};
        take_dialect_mark(source.expression, source.dialect);
        auto expansion = lpe::expand_names(source, job_.macros);
        if (!expansion) return expansion.error();
        auto warnings = lpe::expression_warnings(expansion->source, words_.words);
        if (!warnings) return warnings.error();
        plan_.notes.insert(plan_.notes.end(), warnings->begin(), warnings->end());
        return checked(request, who, expansion->source);
    }

    [[nodiscard]] static Result<std::string> checked(const PassRequest& request, const std::string& who,
                                                     const lpe::ChannelSource& source) {
        if (source.dialect != lpe::Dialect::renderman)
            return error_at(request.location, who + "an expression in the dialect osl; expected the dialect renderman");
        auto bars = lpe::why_no_part(source);
        if (!bars) return bars.error();
        if (!bars->empty())
            return error_at(request.location,
                            who + "an expression with " + *bars + "; expected a plain expression of light");
        return split_prefixes(source.expression).second;
    }

    /// All methods must have the same paths: otherwise one of them misses the longest paths of its class, for example.
    [[nodiscard]] Status check_traits() const {
        transport::IntegratorTraits first;
        for (std::size_t i = 0; i < plan_.passes.size(); ++i) {
            auto chosen = transport::choose_integrator(plan_.passes[i].method, job_.settings.paths.max_depth);
            if (!chosen) return chosen.error();
            const transport::IntegratorTraits traits = chosen->integrator->traits();
            const std::string who = "the passes '" + plan_.passes[0].name + "' and '" + plan_.passes[i].name + "' ";
            if (i > 0 && traits.max_depth != first.max_depth)
                return error_at(job_.passes[i].location,
                                who + "have paths of different lengths, so one of them misses paths",
                                "--max-depth sets the length for all passes");
            if (i > 0 && traits.regularizes != first.regularizes)
                return error_at(job_.passes[i].location,
                                who + "differ in 'regularize', which changes paths; expected one value for all passes");
            if (i == 0) first = traits;
        }
        return success();
    }

    [[nodiscard]] lpe::ChannelSource source_of(const PlannedPass& pass) const {
        return {.name = pass.name, .expression = pass.expression};
    }

    Status prove() {
        std::vector<lpe::ChannelSource> sources;
        for (std::size_t i = 0; i < plan_.passes.size(); ++i)
            if (i != rest_) sources.push_back(source_of(plan_.passes[i]));
        if (sources.empty()) return success();
        std::string summary;
        if (rest_) {
            auto report = lpe::check_disjoint(sources, words_.words);
            if (!report) return report.error();
            if (!report->disjoint) summary = report->summary;
        } else {
            auto report = lpe::check_partition(sources, std::nullopt, words_.words);
            if (!report) return report.error();
            if (report->result == lpe::SplitProof::missed)
                summary = "no pass takes " + report->witness.sentence + " (" + report->witness.text +
                          "); a pass with takes = \"rest\" takes all remaining paths";
            else if (report->result != lpe::SplitProof::partition) summary = report->summary;
        }
        if (!summary.empty()) refute("the passes are no partition of the beauty: " + summary);
        return success();
    }

    void refute(const std::string& message) {
        plan_.refuted = error_at(job_.passes.front().location, message).to_string();
    }

    /// Refutes the plan if a method misses a path of its class that another method samples.
    Status check_methods() {
        for (const PlannedPass& pass : plan_.passes) {
            auto missed = find_missed_path(pass.expression, pass.method, scene_, words_.words);
            if (!missed) return missed.error();
            if (!*missed) continue;
            const MissedPath& path = **missed;
            refute("the pass '" + pass.name + "' misses paths of its class: " + pass.method.type + " does not sample " +
                   path.witness.sentence + " (" + path.witness.text + "); expected this path in a pass by " +
                   (path.methods.empty() ? std::string("another method") : lpe::joined_by(path.methods, " or ")));
            return success();
        }
        return success();
    }

    /// Leaves out passes whose class has no path in this scene.
    Status drop_empty() {
        std::vector<PlannedPass> kept;
        for (PlannedPass& pass : plan_.passes) {
            auto path = lpe::find_path_string(source_of(pass), words_.words);
            if (!path) return path.error();
            if (*path) kept.push_back(std::move(pass));
            else plan_.notes.push_back("the pass '" + pass.name + "' is left out: this scene has no path of its class");
        }
        double shares = 0;
        for (const PlannedPass& pass : kept) shares += pass.time_share;
        for (PlannedPass& pass : kept) pass.time_share /= shares;
        plan_.passes = std::move(kept);
        return success();
    }

    static bool are_equal(const PlannedPass& a, const PlannedPass& b) {
        const auto same = [](const Parameter& x, const Parameter& y) {
            return x.name == y.name && x.numbers == y.numbers && x.strings == y.strings && x.booleans == y.booleans;
        };
        const std::vector<Parameter>&x = a.method.parameters.parameters, &y = b.method.parameters.parameters;
        return a.method.type == b.method.type && a.samples_per_pixel == b.samples_per_pixel &&
               std::equal(x.begin(), x.end(), y.begin(), y.end(), same);
    }

    /// Joins neighbouring passes of the same method and number of samples.
    Status join() {
        std::vector<PlannedPass> joined;
        for (PlannedPass& pass : plan_.passes) {
            if (joined.empty() || !are_equal(joined.back(), pass)) {
                joined.push_back(std::move(pass));
                continue;
            }
            PlannedPass& last = joined.back();
            plan_.notes.push_back("the passes '" + last.name + "' and '" + pass.name +
                                  "' are joined: the methods are equal");
            last.expression = any_path_of({last.expression, pass.expression});
            last.takes += " and " + pass.takes;
            last.time_share += pass.time_share;
            last.has_aovs = last.has_aovs || pass.has_aovs;
        }
        plan_.passes = std::move(joined);
        const auto chosen = std::count_if(plan_.passes.begin(), plan_.passes.end(),
                                          [](const PlannedPass& pass) { return pass.has_aovs; });
        if (chosen > 1)
            return error_at(job_.passes.front().location, "several passes have aovs = true; expected at most one");
        if (chosen == 1 || plan_.passes.empty()) return success();
        std::size_t usual = plan_.passes.size();
        for (std::size_t i = plan_.passes.size(); i-- > 0;)
            if (is_camera_based(plan_.passes[i].method, job_.settings.paths.max_depth)) usual = i;
        plan_.passes[usual < plan_.passes.size() ? usual : 0].has_aovs = true;
        return success();
    }

    /// Light that lands on any pixel has no statistics of samples, so such passes are rendered in two halves.
    Status plan_halves() {
        const std::vector<display::StatisticRequest>& statistics = job_.settings.channels.statistics;
        if (statistics.empty() || plan_.passes.size() < 2) return success();
        for (PlannedPass& pass : plan_.passes) {
            auto chosen = transport::choose_integrator(pass.method, job_.settings.paths.max_depth);
            if (!chosen) return chosen.error();
            if (!chosen->integrator->traits().raster_splats) continue;
            const auto& sampler = job_.settings.samples.sampler ? *job_.settings.samples.sampler : scene_.sampler;
            const auto of_scene = transport::choose_sampler(sampler);
            if (!of_scene) return of_scene.error();
            if (!pass.samples_per_pixel)
                pass.samples_per_pixel = job_.settings.samples.per_pixel.value_or(of_scene->samples_per_pixel);
            constexpr auto least = static_cast<std::uint64_t>(2 * transport::TileGrid::block_size);
            std::string why;
            if (pass.has_aovs) why = "supplies the AOVs; expected aovs = true in a pass by path";
            else if (chosen->integrator->starts_up()) why = "has Markov chains; expected another method";
            else if (job_.settings.stop.limit) why = "ends at a time limit; expected a number of samples";
            else if (*pass.samples_per_pixel < least)
                why = "has " + std::to_string(*pass.samples_per_pixel) + " samples per pixel; expected at least " +
                      std::to_string(least);
            if (!why.empty())
                return error_at(statistics.front().location,
                                "statistics need two halves of the pass '" + pass.name + "', which " + why);
            pass.has_halves = true;
        }
        return success();
    }

    Status add_layers() {
        if (!job_.layer_passes) return success();
        display::PartitionDeclaration partition{"passes", "", {}};
        for (const display::PartitionDeclaration& known : channels_.partitions)
            if (known.name == partition.name)
                return error_at(job_.passes.front().location,
                                "a partition is named 'passes', as the layers of passes; expected another name");
        for (const PlannedPass& pass : plan_.passes) {
            ChannelDefinition layer;
            layer.name = "pass_" + pass.name;
            layer.style = ChannelStyle::expression;
            layer.expression = pass.expression;
            layer.space = "rendering colour space";
            if (Status fits = check_layer_name(layer.name, job_.passes.front().location); !fits) return fits;
            for (const ChannelDefinition& known : channels_.channels)
                if (known.name == layer.name)
                    return error_at(
                        job_.passes.front().location,
                        "a layer is named '" + layer.name + "', as the layer of a pass; expected another name");
            partition.layers.push_back(layer.name);
            channels_.channels.push_back(std::move(layer));
        }
        channels_.partitions.push_back(std::move(partition));
        return success();
    }

    Status restrict_channels() {
        for (const ChannelDefinition& channel : channels_.channels)
            if (Status summable = check_channel(channel); !summable) return summable;
        for (PlannedPass& pass : plan_.passes) {
            for (const ChannelDefinition& channel : channels_.channels) {
                if (channel.style != ChannelStyle::expression) {
                    if (pass.has_aovs) pass.channels.push_back(channel);
                    continue;
                }
                ChannelDefinition part = channel_within(channel, channels_.channels, pass.expression);
                lpe::ChannelSource source{.name = part.name, .expression = part.expression};
                auto path = lpe::find_path_string(source, words_.words);
                if (!path) return path.error();
                if (*path || pass.has_aovs) pass.channels.push_back(std::move(part));
            }
            if (plan_.passes.size() == 1) pass.channels = channels_.channels;
        }
        return success();
    }

    /// Refuses channels of light whose values in several passes have no sum.
    [[nodiscard]] Status check_channel(const ChannelDefinition& channel) const {
        if (channel.style != ChannelStyle::expression || plan_.passes.size() < 2) return success();
        std::string why;
        if (channel.dialect != lpe::Dialect::renderman) why = "is in the dialect osl";
        lpe::ChannelSource source{channel.name, channel.expression, channel.dialect};
        if (why.empty() && channel.rest_of.empty()) {
            auto bars = lpe::why_no_part(source);
            auto prefixes = lpe::expression_prefixes(source);
            if (!bars || !prefixes) return bars ? prefixes.error() : bars.error();
            if (*bars == "user events") why = "has user events";
            for (const std::string& each : *prefixes)
                if (each == "overwrite" || each == "nothruput") why = "has the prefix " + each;
        }
        if (why.empty()) return success();
        return error_at(display::location_of(channel),
                        "channel '" + channel.name + "' " + why + ", which passes do not support",
                        "leave it out, or render it without passes");
    }

    const Job& job_;
    const transport::SceneDescription& scene_;
    const ScenePathStrings& words_;
    ChannelPlan& channels_;
    PassPlan plan_;
    std::optional<std::size_t> rest_;
};

}  // namespace

std::size_t PassPlan::with_aovs() const {
    const auto found =
        std::find_if(passes.begin(), passes.end(), [](const PlannedPass& pass) { return pass.has_aovs; });
    return found == passes.end() ? 0 : static_cast<std::size_t>(found - passes.begin());
}

Status begin_passes(Job& job) {
    if (job.passes.empty()) {
        if (!job.layer_passes) return success();
        return error_at({}, "--layer-passes without passes; expected [[pass]] tables or --pass as well");
    }
    const SourceLocation& where = job.passes.front().location;
    const auto is_light_rule = [&](const auto& request) {
        return request.channel == "beauty" ||
               std::any_of(job.expressions.begin(), job.expressions.end(),
                           [&](const ExpressionRequest& each) { return each.name == request.channel; });
    };
    const auto any_of_light = [&](const auto& requests) {
        return std::any_of(requests.begin(), requests.end(), is_light_rule);
    };
    const transport::RenderSettings& settings = job.settings;
    const auto& statistics = settings.channels.statistics;
    const bool has_variance = std::any_of(statistics.begin(), statistics.end(), [](const auto& each) {
        return each.statistic == display::Statistic::variance;
    });
    const std::pair<bool, const char*> refused[] = {
        {settings.paths.integrator.has_value(), "an integrator for all paths (--integrator)"},
        {!settings.channels.beauty, "no beauty (--no-beauty)"},
        {job.shard.has_value() || job.shard_commands > 0, "shards"},
        {job.checkpoint_seconds > 0 || job.resume, "checkpoints (--checkpoint, --resume)"},
        {!settings.paths.guide_file.empty(), "a guide file (--guide-file)"},
        {settings.buckets.has_value(), "buckets (--memory, --bucket-rows)"},
        {settings.stop.adaptive && !settings.stop.adaptive->channels.empty(), "adaptive sampling by channels"},
        {settings.samples.only.has_value(), "a replayed sample (--replay)"},
        {job.layer_passes && job.outputs.denoise, "layers of passes (--layer-passes) with the denoiser"},
        {!job.outputs.deep.file.empty(), "a deep image (--deep)"},
        {!job.outputs.atlas.file.empty(), "a path atlas (--atlas)"},
        {any_of_light(settings.channels.rules), "a rule for a channel of light"},
        {any_of_light(settings.channels.layers), "a further layer of a channel of light"},
        {has_variance, "the statistic variance; mse, the variance of the pixel, is supported"}};
    for (const auto& [is_there, text] : refused)
        if (is_there)
            return error_at(where, std::string("passes do not support ") + text,
                            "leave it out, or render without passes");
    job.settings.paths.integrator = job.passes.front().method;
    return success();
}

Result<PassPlan> plan_passes(const Job& job, const transport::SceneDescription& scene, const ScenePathStrings& words,
                             ChannelPlan& channels) {
    if (job.passes.empty()) return PassPlan{};
    return PassPlanner(job, scene, words, channels).run();
}

}  // namespace raylex::experiments
