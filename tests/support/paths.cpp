#include "tests/support/paths.h"

namespace raylex::test {

std::string source_dir() {
    return RAYLEX_SOURCE_DIR;
}
std::string binary_dir() {
    return RAYLEX_BINARY_DIR;
}

}  // namespace raylex::test
