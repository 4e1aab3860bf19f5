// The Metropolis integrator's parameters, and what it says of itself.
#include <algorithm>

#include "transport/integrators/methods/bdpt.h"
#include "transport/integrators/methods/pssmlt_state.h"

namespace raylex::transport {
namespace {

Result<std::unique_ptr<Integrator>> make_pssmlt(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    IntegratorParameters read(entity);
    PssmltParameters p;
    p.max_depth = read.max_depth(max_depth);
    p.large_step_probability = read.fraction("largestepprobability", Real(0.3),
                                             ": without large steps a chain may never leave where it began");
    p.sigma = read.fraction("sigma", Real(0.01));
    p.chains = static_cast<std::uint32_t>(read.integer("chains", 1000, 1, 1'000'000));
    p.bootstrap_samples = static_cast<std::uint32_t>(read.integer("bootstrapsamples", 100'000, 1, 1'000'000'000));
    p.roulette_below = read.roulette_below();
    p.bidirectional = read.choice("integrator", {"path", "bdpt"}, 0) == 1;
    const std::string target = read.string("target", "beauty");
    if (read.error()) return *read.error();
    for (std::size_t begin = 0; begin <= target.size();) {
        const std::size_t end = std::min(target.find(',', begin), target.size());
        if (end == begin)
            return error_at(entity.location,
                            "'target' is '" + target + "'; expected beauty, or names of channels between commas");
        p.target.push_back(target.substr(begin, end - begin));
        begin = end + 1;
    }
    if (target == "beauty") p.target.clear();
    p.location = entity.location;
    return std::unique_ptr<Integrator>(std::make_unique<Pssmlt>(p));
}

}  // namespace

Registry<IntegratorFactory>::Entry pssmlt_entry() {
    using T = ParameterType;
    return {"pssmlt",
            "Metropolis light transport in primary sample space, over path or bdpt",
            {describe_max_depth(),
             {"largestepprobability", T::real, "0.3", "share of steps that draw a new path"},
             {"sigma", T::real, "0.01", "standard deviation of the other steps, in each number of the path"},
             {"chains", T::integer, "1000", "Markov chains; at least one is run for each 16 x 16 tile"},
             {"bootstrapsamples", T::integer, "100000",
              "paths drawn before the image, for its brightness and where chains begin"},
             describe_roulette("paths"),
             describe_roulette_threshold(),
             {"integrator", T::string, "path", "whose paths the chains walk over: path or bdpt"},
             {"target", T::string, "beauty",
              "what chains spend their steps on: beauty, or channels of light path expressions between commas"}},
            make_pssmlt};
}

Pssmlt::Pssmlt(const PssmltParameters& parameters) : parameters_(parameters) {
    PathParameters seen, found;
    seen.max_depth = 0;
    camera_ = make_path_integrator(seen);
    found.max_depth = parameters.max_depth;
    found.first_depth = 1;
    found.roulette_below = parameters.roulette_below;
    seen.splits = found.splits = false;  // a chain's numbers are of one path
    path_ = parameters.bidirectional ? make_bdpt_integrator({{parameters.max_depth, parameters.roulette_below}, 1})
                                     : make_path_integrator(found);
}

IntegratorTraits Pssmlt::traits() const {
    IntegratorTraits traits;
    traits.max_depth = parameters_.max_depth;
    traits.media = true;
    traits.first_hits = traits.cutouts = true;
    traits.user_events = true;
    traits.raster_splats = true;
    traits.tells_words = false;  // chains keep what channels get of a path, and splat that again and again
    return traits;
}

Status Pssmlt::prepare(const IntegratorContext& context) {
    context_ = context;
    splatted_.clear();
    for (std::size_t i = 0; i < context.services.channels.size(); ++i)
        if (context.services.channels[i].style == display::ChannelStyle::expression &&
            display::takes_samples(context.services.channels[i]))
            splatted_.push_back(static_cast<display::ChannelId>(i));
    target_ = splatted_;
    if (context.beauty) target_.resize(1);  // beauty stands first
    if (!parameters_.target.empty()) {
        target_.clear();
        std::string names;
        std::vector<std::string> known;
        for (const display::ChannelId id : splatted_) {
            known.push_back(context.services.channels[static_cast<std::size_t>(id)].name);
            names += (names.empty() ? "" : ", ") + known.back();
        }
        for (const std::string& name : parameters_.target) {
            const auto found = std::find(known.begin(), known.end(), name);
            if (found == known.end())
                return error_at(
                    parameters_.location,
                    "'target' names the channel '" + name + "', which takes no light here; expected some of: " + names,
                    near_miss(name, known));
            target_.push_back(splatted_[static_cast<std::size_t>(found - known.begin())]);
        }
    }
    const Vec2 reach{std::max(context.view.filter_radius.x - Real(0.5), Real(0)),
                     std::max(context.view.filter_radius.y - Real(0.5), Real(0))};
    left_ = -reach.x;
    top_ = -reach.y;
    across_ = static_cast<Real>(context.view.width) + 2 * reach.x;
    down_ = static_cast<Real>(context.view.height) + 2 * reach.y;
    area_share_ = static_cast<double>(across_) * static_cast<double>(down_) /
                  (static_cast<double>(context.view.width) * static_cast<double>(context.view.height));
    chains_ = parameters_.max_depth > 0 && context.takes_scattered_light();
    groups_ = std::vector<ChainGroup>(context.tiles);
    const std::size_t each = std::max<std::size_t>(1, (parameters_.chains + context.tiles / 2) / context.tiles);
    for (ChainGroup& group : groups_) group.chains.resize(each);
    if (Status camera = camera_->prepare(context); !camera) return camera;
    IntegratorContext of_paths = context;  // chains bring light and nothing else
    of_paths.first_hits.aovs = &no_aovs_;
    of_paths.first_hits.pattern_channels = false;
    return path_->prepare(of_paths);
}

std::unique_ptr<IntegratorThread> Pssmlt::make_thread_state() const {
    return std::make_unique<PssmltThread>(context_, *camera_, *path_, splatted_, target_);
}

}  // namespace raylex::transport
