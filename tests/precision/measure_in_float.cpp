// Writes what float makes of the measurements to a file: each list's length and its numbers.
#include <cstdint>
#include <fstream>

#include "precision/measure.h"
#include "transport/math/real.h"

static_assert(!raylex::transport::real_is_double);

int main(int count, char** arguments) {
    if (count != 2) return 2;
    raylex::test::Measurements measurements = raylex::test::measure();
    std::ofstream file(arguments[1], std::ios::binary);
    for (const std::vector<double>* list : measurements.all()) {
        const std::uint64_t size = list->size();
        file.write(reinterpret_cast<const char*>(&size), sizeof size);
        file.write(reinterpret_cast<const char*>(list->data()), static_cast<std::streamsize>(size * sizeof(double)));
    }
    return file.good() ? 0 : 1;
}
