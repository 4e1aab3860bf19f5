// Where the sources and the build lie, for tests that read or write files there.
#pragma once

#include <string>

namespace raylex::test {

std::string source_dir();
std::string binary_dir();

}  // namespace raylex::test
