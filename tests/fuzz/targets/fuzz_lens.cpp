// Any bytes as a lens file: what is read has elements of positive width, and rays through it stay numbers.
#include <cmath>

#include "tests/fuzz/fuzz.h"
#include "transport/cameras/lens_system.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace raylex::transport;
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    const fuzz::MemoryFile file(data, size);
    const raylex::SourceLocation where{"scene.pbrt", 1, 1};
    std::vector<raylex::Error> warnings;
    auto lens = LensSystem::read(file.path(), 0.002, Aperture(), where, warnings);
    if (!lens) {
        fuzz::require(!lens.error().message.empty(), "a refusal says why");
        return 0;
    }
    fuzz::require(!lens->elements().empty(), "there are elements");
    for (const LensElement& element : lens->elements())
        fuzz::require(element.radius > 0 && element.thickness >= 0 && element.eta >= 1, "elements are as they must be");
    if (!lens->focus(2, where)) return 0;
    fuzz::require(lens->rear_z() > 0 && std::isfinite(lens->rear_z()), "a lens in focus stands before the film");
    for (const double height : {-0.9, 0.0, 0.3}) {
        const DVec3 film(0.004, 0, 0);
        LensRay ray{film, normalize(DVec3(0, height * double{lens->rear_radius()}, lens->rear_z()) - film)};
        const double left = lens->trace(ray);
        fuzz::require(left >= 0 && left <= 1, "a lens passes a part of the light");
        if (left > 0)
            fuzz::require(std::isfinite(length(ray.origin)) && std::isfinite(length(ray.direction)),
                          "rays are numbers");
    }
    return 0;
}
