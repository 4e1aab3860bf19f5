#include "transport/cameras/screen_window.h"

namespace raylex::transport {

Result<std::array<double, 4>> read_screen_window(const SceneEntity& entity, const CameraPlacement& placement) {
    const ParameterSet& set = entity.parameters;
    auto aspect =
        set.real_or("frameaspectratio", static_cast<double>(placement.width) / static_cast<double>(placement.height));
    if (!aspect) return aspect.error();
    if (!(*aspect > 0)) return error_at(entity.location, "'frameaspectratio' must be positive");
    std::array<double, 4> screen = *aspect > 1 ? std::array<double, 4>{-*aspect, *aspect, -1, 1}
                                               : std::array<double, 4>{-1, 1, -1 / *aspect, 1 / *aspect};
    if (const Parameter* p = set.find("screenwindow")) {
        if (p->numbers.size() != 4)
            return error_at(p->location, "'screenwindow' must be four numbers: x min, x max, y min, y max");
        for (std::size_t i = 0; i < 4; ++i) screen[i] = p->numbers[i];
        if (screen[0] == screen[1] || screen[2] == screen[3])
            return error_at(p->location, "'screenwindow' has no extent; expected x min, x max, y min, y max");
    }
    return screen;
}

Result<ThinLens> read_thin_lens(const SceneEntity& entity) {
    auto lens = entity.parameters.real_or("lensradius", 0), focus = entity.parameters.real_or("focaldistance", 1e6);
    for (const auto* each : {&lens, &focus})
        if (!*each) return each->error();
    if (!(*focus > 0)) return error_at(entity.location, "'focaldistance' must be positive");
    return ThinLens{*lens, *focus};
}

}  // namespace raylex::transport
