// Saves a finished result elsewhere if its file cannot be written, for example on a full disk.
#pragma once

#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Calls `write` with an unused name in the folder for temporary files ($TMPDIR), because writing `what` ("the image")
/// to `path` failed. Returns `failure` with a hint that names the new file, or that says that saving failed there too.
Error rescued(Error failure, const std::string& what, const std::string& path,
              const std::function<Status(const std::string& path)>& write);

}  // namespace raylex::experiments
