// The folders of the sources and of the build, for tests that read or write files there.
#pragma once

#include <string>

namespace raylex::test {

std::string source_dir();
std::string binary_dir();

}  // namespace raylex::test
