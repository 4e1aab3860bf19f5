// The Metropolis integrator's parameters, and what it says of itself.
#include <algorithm>

#include "transport/integrators/methods/bdpt.h"
#include "transport/integrators/methods/pssmlt_state.h"

namespace raylex::transport {
namespace {

Result<std::unique_ptr<Integrator>> make_pssmlt(const SceneEntity& entity, std::optional<std::int64_t> max_depth) {
    PssmltParameters p;
    auto depth = read_max_depth(entity, max_depth);
    if (!depth) return depth.error();
    p.max_depth = *depth;
    auto large = entity.parameters.real_or("largestepprobability", 0.3),
         sigma = entity.parameters.real_or("sigma", 0.01);
    if (!large) return large.error();
    if (!sigma) return sigma.error();
    if (!(*large > 0 && *large <= 1))
        return error_at(entity.location,
                        "'largestepprobability' is " + std::to_string(*large) +
                            "; expected more than 0 and at most 1: without large steps a chain may never "
                            "leave where it began");
    if (!(*sigma > 0 && *sigma <= 1))
        return error_at(entity.location,
                        "'sigma' is " + std::to_string(*sigma) + "; expected more than 0 and at most 1");
    p.large_step_probability = static_cast<Real>(*large);
    p.sigma = static_cast<Real>(*sigma);
    auto chains = entity.parameters.integer_or("chains", 1000),
         samples = entity.parameters.integer_or("bootstrapsamples", 100'000);
    if (!chains) return chains.error();
    if (!samples) return samples.error();
    if (*chains < 1 || *chains > 1'000'000)
        return error_at(entity.location, "'chains' is " + std::to_string(*chains) + "; expected 1 to a million");
    if (*samples < 1 || *samples > 1'000'000'000)
        return error_at(entity.location,
                        "'bootstrapsamples' is " + std::to_string(*samples) + "; expected 1 to a thousand million");
    p.chains = static_cast<std::uint32_t>(*chains);
    p.bootstrap_samples = static_cast<std::uint32_t>(*samples);
    auto roulette = read_roulette(entity);
    if (!roulette) return roulette.error();
    p.roulette_below = *roulette;
    auto integrator = entity.parameters.choice_or("integrator", "path", {"path", "bdpt"});
    if (!integrator) return integrator.error();
    p.bidirectional = *integrator == "bdpt";
    auto target = entity.parameters.string_or("target", "beauty");
    if (!target) return target.error();
    for (std::size_t begin = 0; begin <= target->size();) {
        const std::size_t end = std::min(target->find(',', begin), target->size());
        if (end == begin)
            return error_at(entity.location,
                            "'target' is '" + *target + "'; expected beauty, or names of channels between commas");
        p.target.push_back(target->substr(begin, end - begin));
        begin = end + 1;
    }
    if (*target == "beauty") p.target.clear();
    p.location = entity.location;
    return std::unique_ptr<Integrator>(std::make_unique<Pssmlt>(p));
}

}  // namespace

Registry<IntegratorFactory>::Entry pssmlt_entry() {
    using T = ParameterType;
    return {"pssmlt",
            "Metropolis light transport in primary sample space, over path or bdpt",
            {{"maxdepth", T::integer, "5", "scattering events at most; emission seen after the last still counts"},
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
    for (std::size_t i = 0; i < context.channels.size(); ++i)
        if (context.channels[i].style == display::ChannelStyle::expression &&
            display::takes_samples(context.channels[i]))
            splatted_.push_back(static_cast<display::ChannelId>(i));
    target_ = splatted_;
    if (context.beauty) target_.resize(1);  // beauty stands first
    if (!parameters_.target.empty()) {
        target_.clear();
        std::string names;
        std::vector<std::string> known;
        for (const display::ChannelId id : splatted_) {
            known.push_back(context.channels[static_cast<std::size_t>(id)].name);
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
    const Vec2 reach{std::max(context.filter_radius.x - Real(0.5), Real(0)),
                     std::max(context.filter_radius.y - Real(0.5), Real(0))};
    left_ = -reach.x;
    top_ = -reach.y;
    across_ = static_cast<Real>(context.width) + 2 * reach.x;
    down_ = static_cast<Real>(context.height) + 2 * reach.y;
    area_share_ = static_cast<double>(across_) * static_cast<double>(down_) /
                  (static_cast<double>(context.width) * static_cast<double>(context.height));
    const EventTable& events = *context.events;
    chains_ =
        parameters_.max_depth > 0 && (context.beauty || (events.any() && events.foresight().at_camera().scatters));
    not_begun_ = parameters_.max_depth > 0 && !chains_ && events.any();
    groups_ = std::vector<ChainGroup>(context.tiles);
    const std::size_t each = std::max<std::size_t>(1, (parameters_.chains + context.tiles / 2) / context.tiles);
    for (ChainGroup& group : groups_) group.chains.resize(each);
    if (Status camera = camera_->prepare(context); !camera) return camera;
    IntegratorContext of_paths = context;  // chains bring light and nothing else
    of_paths.aovs = &no_aovs_;
    of_paths.pattern_channels = false;
    return path_->prepare(of_paths);
}

std::unique_ptr<IntegratorThread> Pssmlt::make_thread_state() const {
    return std::make_unique<PssmltThread>(context_, *camera_, *path_, splatted_, target_);
}

}  // namespace raylex::transport
