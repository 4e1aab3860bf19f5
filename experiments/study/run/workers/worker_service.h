// The operations of a cell worker's process on scenes, cells and references, as messages.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "experiments/study/plan/plan.h"
#include "experiments/study/run/processes/child_process.h"

namespace raylex::experiments {

enum class Operation : int { describe, frame_buffer, reason_to_keep, calibrate, reference, run, close };

/// Returns a responder to the messages of RunWorker. The config and the plan must outlive it.
Responder make_worker_service(const ExperimentConfig& config, const Plan& plan, std::string directory,
                              const std::atomic<bool>* stop);

}  // namespace raylex::experiments
