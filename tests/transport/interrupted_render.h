// Renders that stop at a chosen sample, and the files they leave.
#pragma once

#include <atomic>
#include <string>

#include "tests/support/folder.h"
#include "transport/render_support.h"

namespace render_test {

/// A file that does not exist yet, in a folder of its own.
class ScratchFile {
  public:
    [[nodiscard]] std::string path() const { return folder_.path(name); }
    [[nodiscard]] bool exists() const { return folder_.has(name); }
    [[nodiscard]] std::string bytes() const { return folder_.read(name); }
    void write(const std::string& bytes) const { folder_.write(name, bytes); }

  private:
    static constexpr const char* name = "image.checkpoint";
    raylex::test::Folder folder_;
};

/// Stops a render from within after a number of camera samples: a clock would stop it anywhere or, on a fast machine,
/// never.
class Interruption {
  public:
    void begin(std::uint64_t samples, std::atomic<bool>* stop) {
        left_.store(static_cast<std::int64_t>(samples));
        stop_.store(stop);
    }
    void count(std::size_t samples) {
        std::atomic<bool>* const stop = stop_.load();
        if (stop != nullptr &&
            left_.fetch_sub(static_cast<std::int64_t>(samples)) <= static_cast<std::int64_t>(samples))
            stop->store(true);
    }

  private:
    std::atomic<std::int64_t> left_{0};
    std::atomic<std::atomic<bool>*> stop_{nullptr};
};
inline Interruption& interruption() {
    static Interruption one;
    return one;
}

/// Another integrator with a count of its camera samples: for integrators without iterations and state between them.
class CountedIntegrator final : public transport::Integrator {
  public:
    explicit CountedIntegrator(std::unique_ptr<transport::Integrator> counted) : counted_(std::move(counted)) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override { return counted_->traits(); }
    [[nodiscard]] transport::PlanRequest plan_request() const override { return counted_->plan_request(); }
    [[nodiscard]] transport::GuideRequest guide_request() const override { return counted_->guide_request(); }
    raylex::Status prepare(const transport::IntegratorContext& context) override { return counted_->prepare(context); }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return counted_->make_thread_state();
    }
    void integrate(const transport::CameraBatch& batch, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        counted_->integrate(batch, thread, services);
        interruption().count(batch.rays.size());
    }

  private:
    std::unique_ptr<transport::Integrator> counted_;
};

inline transport::SceneEntity counted(const std::string& integrator) {
    transport::SceneEntity entity;
    entity.type = "counted " + integrator;
    transport::integrator_registry().add(
        {entity.type,
         "for this test",
         {{"maxdepth", raylex::ParameterType::integer, "5", "as in the counted integrator"}},
         [integrator](const transport::SceneEntity& scene,
                      std::optional<std::int64_t> max_depth) -> raylex::Result<std::unique_ptr<transport::Integrator>> {
             transport::SceneEntity inner;
             inner.type = integrator;
             inner.parameters = scene.parameters;  // the parameters of the scene's file, such as its depth
             auto chosen = transport::choose_integrator(inner, max_depth);
             if (!chosen) return chosen.error();
             return std::unique_ptr<transport::Integrator>(
                 std::make_unique<CountedIntegrator>(std::move(chosen->integrator)));
         }});
    return entity;
}

}  // namespace render_test
