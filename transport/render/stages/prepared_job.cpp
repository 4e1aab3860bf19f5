#include "transport/render/stages/prepared_job.h"

#include <algorithm>
#include <exception>

#include "display/services/channel_prefixes.h"
#include "lpe/algebra/proofs/check.h"
#include "transport/render/clock.h"
#include "transport/render/pilots/guide_viewer.h"
#include "transport/render/stages/checkpoint.h"
#include "transport/render/stages/render_worker.h"

namespace raylex::transport {
namespace {

constexpr double guide_time_share = 1.0 / 4;  // of a time limit, for the training of a guide

/// Whether a channel receives light without its path's throughput. The probability of paths then affects its values, so
/// nothing may be pruned (Law 4). User events of surfaces are sampled in the same way.
Result<bool> counts_paths(const std::vector<display::ChannelDefinition>& channels) {
    for (const display::ChannelDefinition& channel : channels) {
        auto prefixes = display::read_prefixes(channel);
        if (!prefixes) return prefixes.error();
        if (!prefixes->nothruput) continue;
        lpe::ChannelSource source;
        source.expression = channel.expression;
        source.dialect = channel.dialect;
        auto word = lpe::find_path_string(source);
        if (!word) return word.error();
        if (*word) return true;
    }
    return false;
}

}  // namespace

IntegratorContext PreparedJob::context() const {
    IntegratorContext context;
    context.scene = job.scene.view();
    context.events = events.get();
    context.first_hits.aovs = aovs.get();
    context.first_hits.pattern_channels = job.channels.written_by_plugins;
    context.view = {.camera = job.sampling.camera.get(),
                    .width = job.grid.width,
                    .height = job.grid.height,
                    .filter_radius = {job.sampling.filter->radius_x(), job.sampling.filter->radius_y()}};
    context.view.camera->rigid_world_to_camera(context.first_hits.world_to_camera);
    context.first_hits.pixel_size = context.view.camera->pixel_size();
    context.services = {.channels = job.channels.list,
                        .lpe = job.channels.lpe.get(),
                        .seed = job.sampling.seed,
                        .attribution = job.channels.attribution};
    context.beauty = job.channels.takes_all;
    context.batch_capacity = RenderWorker::batch_capacity;
    context.tiles = static_cast<std::uint32_t>(job.grid.count());
    context.plan = paths ? &paths->plan : nullptr;
    context.directions = guide.guide.get();
    return context;
}

/// The training that the integrator requests. With a beauty it alone counts: what a guide learns, and so the image,
/// depends on no other channel (Law 2).
GuideTraining PreparedJob::training() const {
    GuideTraining training;
    training.request = job.guide_request();
    training.channels =
        job.channels.beauty >= 0 ? std::vector{job.channels.beauty} : context().services.light_channels();
    training.threads = job.threads;
    training.whole = job.budget.whole;
    if (training.request.samples == 0 && job.budget.limit)
        training.seconds = guide_time_share * job.budget.limit->seconds;
    return training;
}

/// Trains the guide if the integrator has one. A resumed render has the guide of its checkpoint.
Status PreparedJob::train(GuideTraining training, GuideFile file, const Stopwatch& since_call,
                          const std::atomic<bool>* stop) {
    if (training.request.mode == GuideMode::off) return success();
    if (auto saved = saved_guide(job); !saved) return saved.error();
    else if (*saved) {
        guide = **std::move(saved);
        if (!guide.summary.cut && !guide.summary.read) unwritten = std::move(file);
        return success();
    }
    if (file.guide) {
        guide = *std::move(file.guide);
        return success();
    }
    const double limit = job.budget.limit && !job.budget.only ? job.budget.limit->seconds : 0;
    // Half of the time is for the image, whatever the training takes.
    training.stopped = [&since_call, stop, limit] {
        return (stop != nullptr && stop->load(std::memory_order_relaxed)) ||
               (limit > 0 && since_call.wall() > limit / 2);
    };
    guide = train_guide(context(), training);
    if (!guide.summary.cut) file.write(guide, job.warnings);
    else if (limit > 0 && since_call.wall() > limit / 2)
        job.warnings.push_back(
            error_at({}, "the guide took half of the time limit for its training, and is not used",
                     "expected a smaller 'guidesamples'; the integrator's guide = \"off\" renders the same bits"));
    else guide = {};  // the render ends too, and its next session trains again
    return success();
}

Result<PreparedJob> PreparedJob::prepare(ResolvedJob resolved, const Stopwatch& since_call,
                                         const std::atomic<bool>* stop) {
    const Stopwatch watch;
    PreparedJob prepared(std::move(resolved));
    ResolvedJob& job = prepared.job;
    const bool regularizes = job.integrator().traits().regularizes;
    if (job.settings.labels.words) {
        auto alphabet = display::PathAlphabet::build(
            scene_events(job.scene.view(), job.settings.labels.lobe_slots, regularizes), *job.settings.labels.words);
        if (!alphabet) return alphabet.error();
        if (Status s = job.channels.lpe->keep_path_strings(*std::move(alphabet)); !s) return s.error();
    }
    const auto counts = counts_paths(job.channels.list);
    if (!counts) return counts.error();
    prepared.events =
        std::make_unique<const EventTable>(*job.channels.lpe, job.scene.view(), job.settings.labels.lobe_slots,
                                           job.settings.paths.prune && !*counts, regularizes);
    prepared.aovs = std::make_unique<const geoaovs::GeometricAovs>(job.channels.list);
    GuideTraining training = prepared.training();
    auto file = GuideFile::open(job, prepared.context(), training);  // before a ray is traced
    if (!file) return file.error();
    PlanRequest request = job.integrator().plan_request();
    // Pilots choose splits and roulette by the light of all channels, which the beauty of a class must not depend on
    // (Law 2). The choice of techniques depends on live light, and so on the class alone.
    if (!job.settings.channels.takes.empty()) request.splits = request.roulette = false;
    prepared.paths = std::make_unique<const PlannedPaths>(make_path_plan(prepared.context(), request));
    try {
        if (Status s = prepared.train(std::move(training), *std::move(file), since_call, stop); !s) return s.error();
        if (job.settings.paths.guide_view && prepared.guide.guide)
            prepared.guide_view =
                view_guide(prepared.context(), job.integrator().guide_request(), *prepared.guide.guide, stop);
    } catch (const std::exception& e) {
        return error_at({}, std::string("the training of the guide failed: ") + e.what());
    } catch (...) {
        return error_at({}, "the training of the guide failed: a plugin threw an object that is not a std::exception");
    }
    if (Status s = job.integrator().prepare(prepared.context()); !s) return s.error();
    for (Omission& omission : job.integrator().omissions())
        if (!omission.is_declared || job.settings.channels.takes.empty())
            job.warnings.push_back(error_at({}, std::move(omission.text)));
    if (!job.integrator().traits().cutouts && job.scene.view().tests_alpha())
        job.warnings.push_back(
            error_at({},
                     "the scene has cutouts or interfaces, and integrator '" + job.chosen.name +
                         "' does not declare that its rays pass through them; they may be rendered as opaque",
                     "integrators declare it by IntegratorTraits::cutouts"));
    prepared.seconds = watch.wall();
    prepared.cpu_seconds = watch.process_cpu();
    return prepared;
}

}  // namespace raylex::transport
