// An integrator that ends its process, or never ends, in a way that the scene chooses.
#include <unistd.h>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

void die(const std::string& way) {
    if (way == "abort") {
        std::fputs("last words of the scene\n", stderr);
        std::abort();
    }
    if (way == "segmentation") std::raise(SIGSEGV);
    if (way == "kill") kill(getpid(), SIGKILL);
    if (way == "exit") _exit(7);
    if (way == "exception") throw std::runtime_error("thrown by the scene");
    while (way == "endless") std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

struct Deadly : Integrator {
    std::string way;
    Status prepare(const IntegratorContext& /*context*/) override { return success(); }
    void integrate(const CameraBatch& /*camera*/, IntegratorThread& /*thread*/,
                   ThreadServices& /*services*/) const override {
        die(way);
    }
};

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_integrator(
        {"deadly",
         "ends its process",
         {{"way", raylex::ParameterType::string, "", "abort, segmentation, kill, exit, exception, endless"},
          {"at", raylex::ParameterType::string, "rendering", "rendering or loading"}},
         [](const SceneEntity& entity, auto) -> Result<std::unique_ptr<Integrator>> {
             auto made = std::make_unique<Deadly>();
             auto way = entity.parameters.string_or("way", ""), at = entity.parameters.string_or("at", "rendering");
             if (!way) return way.error();
             if (!at) return at.error();
             made->way = *way;
             if (*at == "loading") die(made->way);
             return std::unique_ptr<Integrator>(std::move(made));
         }});
}
