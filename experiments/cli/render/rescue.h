// What was rendered and cannot be written to its place after all: a full disk.
#pragma once

#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Before `what` ("the image"), which was to stand at `path`, is given up, `write` is called with a name in the folder
/// for temporary files ($TMPDIR), that of no file there. The failure comes back; its hint says where the file is now,
/// or that it could not be saved there either.
Error rescued(Error failure, const std::string& what, const std::string& path,
              const std::function<Status(const std::string& path)>& write);

}  // namespace raylex::experiments
