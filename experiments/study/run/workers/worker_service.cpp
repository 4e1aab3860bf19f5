#include "experiments/study/run/workers/worker_service.h"

#include <exception>
#include <new>
#include <utility>

#include "experiments/study/run/cells/run_files.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/cells/run_renderer.h"
#include "experiments/study/run/processes/messages.h"
#include "experiments/study/run/workers/estimates.h"
#include "transport/render/clock.h"

namespace raylex::experiments {
namespace {

class Service {
  public:
    Service(const ExperimentConfig& config, const Plan& plan, std::string directory, const std::atomic<bool>* stop)
        : config_(config), plan_(plan), directory_(std::move(directory)), stop_(stop), scenes_(config) {}

    std::string answer(const std::string& request, const Tell& tell) {
        const double before = scenes_.seconds();
        Message answer;
        try {
            auto done = work(unpacked(request), tell);
            if (done) answer["result"] = *std::move(done);
            else answer["error"] = done.error();
        } catch (const std::bad_alloc&) {
            answer["thrown"] = true;
            answer["error"] =
                error_at({}, "out of memory; use a smaller scene, a smaller resolution or fewer channels");
        } catch (const std::exception& error) {
            answer["thrown"] = true;
            answer["error"] = error_at({}, error.what());
        }
        answer["render_seconds"] = scenes_.seconds() - before;
        return packed(answer);
    }

  private:
    Result<Message> work(const Message& request, const Tell& tell) {
        const std::size_t scene = request.value("scene", std::size_t{0}),
                          variant = request.value("variant", std::size_t{0});
        switch (static_cast<Operation>(request.at("operation").get<int>())) {
            case Operation::describe:
                return describe(scene, variant);
            case Operation::frame_buffer: {
                auto bytes = scenes_.frame_buffer_bytes(scene, variant);
                return bytes ? Result<Message>(Message(*bytes)) : Result<Message>(bytes.error());
            }
            case Operation::reason_to_keep:
                return Message(reason_of_scene(config_, scene, variant, scenes_));
            case Operation::calibrate:
                return calibrate(scene, variant);
            case Operation::reference:
                return reference(scene, request.at("info"), tell);
            case Operation::run:
                return run(request, {run_of_message(request.at("cell")), scene, variant}, tell);
            case Operation::close:
                break;
        }
        const Status closed = closer().wait();
        return closed ? Result<Message>(Message(true)) : Result<Message>(closed.error());
    }

    RunCloser& closer() {
        if (closer_ == nullptr) closer_ = std::make_unique<RunCloser>();
        return *closer_;
    }

    WorkContext context(const Tell& tell) {
        // Ten updates a second are enough for people.
        const auto since = std::make_shared<transport::Stopwatch>();
        const auto told = std::make_shared<double>(-1.0);
        return {config_,
                plan_,
                scenes_,
                directory_,
                [=](const WorkProgress& now) {
                    if (*told >= 0 && since->wall() - *told < 0.1 && now.process_group == 0) return;
                    *told = since->wall();
                    tell(packed({now.share, now.seconds, now.error, now.process_group}));
                },
                stop_,
                &closer()};
    }

    Result<Message> describe(std::size_t index, std::size_t variant) {
        auto scene = scenes_.scene(index);
        if (!scene) return scene.error();
        SceneInfo info;
        info.hash = (*scene)->hash;
        info.width = (*scene)->width;
        info.height = (*scene)->height;
        auto channels = scenes_.channels(index, variant);
        if (!channels) return channels.error();
        info.channels = channel_infos(**channels);
        std::vector<PartitionInfo> partitions;
        for (const display::PartitionDeclaration& each : (*channels)->partitions)
            partitions.push_back({each.name, each.of.empty() ? "beauty" : each.of, each.layers});
        return Message{{"info", info}, {"partitions", partitions}};
    }

    Result<Message> calibrate(std::size_t scene, std::size_t variant) {
        auto measured = calibration_of(config_, scenes_, scene, variant, stop_);
        if (!measured) return measured.error();
        return Message(*measured);
    }

    Result<Message> reference(std::size_t scene, SceneInfo info, const Tell& tell) {
        double seconds = 0;
        auto made = provide_reference(context(tell), scene, info, seconds);
        if (!made) return made.error();
        return Message{{"made", *made}, {"info", info}, {"seconds", seconds}};
    }

    Result<Message> run(const Message& request, const PlannedRun& planned, const Tell& tell) {
        auto outcome = render_run(context(tell), planned, request.at("seconds_per_sample"));
        if (!outcome) return outcome.error();
        return Message{{"cell", run_message(outcome->run)},
                       {"stopped", outcome->stopped},
                       {"relative_error", outcome->relative_error},
                       {"outside_seconds", outcome->outside_seconds}};
    }

    const ExperimentConfig& config_;
    const Plan& plan_;
    std::string directory_;
    const std::atomic<bool>* stop_;
    SceneStore scenes_;
    std::unique_ptr<RunCloser> closer_;
};

}  // namespace

Responder make_worker_service(const ExperimentConfig& config, const Plan& plan, std::string directory,
                              const std::atomic<bool>* stop) {
    auto service = std::make_shared<Service>(config, plan, std::move(directory), stop);
    return [service](const std::string& request, const Tell& tell) { return service->answer(request, tell); };
}

}  // namespace raylex::experiments
