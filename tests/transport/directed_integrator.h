// An integrator whose directions a sampler of a test draws.
#pragma once

#include <memory>
#include <string>

#include "transport/integrators/integrator.h"

namespace render_test {

namespace transport = raylex::transport;

/// Another integrator, prepared with a sampler of directions.
class DirectedIntegrator final : public transport::Integrator {
  public:
    DirectedIntegrator(std::unique_ptr<Integrator> inner, std::shared_ptr<const transport::DirectionSampler> directions)
        : inner_(std::move(inner)), directions_(std::move(directions)) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override { return inner_->traits(); }
    raylex::Status prepare(const transport::IntegratorContext& context) override {
        transport::IntegratorContext directed = context;
        directed.directions = directions_.get();
        return inner_->prepare(directed);
    }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return inner_->make_thread_state();
    }
    void integrate(const transport::CameraBatch& batch, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        inner_->integrate(batch, thread, services);
    }

  private:
    std::unique_ptr<Integrator> inner_;
    std::shared_ptr<const transport::DirectionSampler> directions_;
};

/// Registers `name`: the integrator `inner` with its parameters, and with directions of `directions`.
inline void register_directed(const std::string& name, const std::string& inner,
                              const std::shared_ptr<const transport::DirectionSampler>& directions) {
    auto& registry = transport::integrator_registry();
    auto entry = *registry.find(inner);
    entry.name = name;
    entry.factory =
        [factory = entry.factory, directions](
            const transport::SceneEntity& entity,
            std::optional<std::int64_t> max_depth) -> raylex::Result<std::unique_ptr<transport::Integrator>> {
        auto made = factory(entity, max_depth);
        if (!made) return made.error();
        return std::unique_ptr<transport::Integrator>(
            std::make_unique<DirectedIntegrator>(*std::move(made), directions));
    };
    registry.add(std::move(entry));
}

}  // namespace render_test
