#include "transport/render/resolve/channel_scales.h"

#include <algorithm>
#include <cmath>

#include "geoaovs/geoaovs.h"

namespace raylex::transport {
namespace {

/// The binary exponent by which a size exceeds 2^20 or falls below 2^-20; 0 in between.
int beyond(double size) {
    constexpr int usual = 20;
    if (!(size > 0) || !std::isfinite(size)) return 0;
    const int exponent = std::ilogb(size);
    return exponent - std::clamp(exponent, -usual, usual);
}

/// The radiance of the brightest light, or for a light without extent its irradiance at the scene's radius.
double brightest_light(const BuiltScene& scene) {
    const double radius = double(scene.view().geometry->bounds().radius());
    double brightest = 0;
    for (const Light& light : scene.view().lights->lights()) {
        const double emission = double(light.emission.max());
        const double seen = light.is_at_point() && radius > 0 ? emission / (radius * radius) : emission;
        brightest = std::max(brightest, seen);
    }
    // The emission along the scene's diameter.
    const MediumTable& media = *scene.view().media;
    for (std::size_t i = 0; i < media.size(); ++i)
        brightest =
            std::max(brightest,
                     double(brightest_glow(media[static_cast<std::int32_t>(i)], static_cast<Real>(2 * radius)).max()));
    return brightest;
}

/// The largest coordinate of hits, in the world.
double extent(const BuiltScene& scene) {
    const Bounds& bounds = scene.view().geometry->bounds();
    const DVec3 origin = scene.view().geometry->space().origin;
    double largest = 0;
    for (const DVec3& corner : {DVec3(bounds.lower) + origin, DVec3(bounds.upper) + origin})
        for (const double each : {corner.x, corner.y, corner.z}) largest = std::max(largest, std::abs(each));
    return largest;
}

}  // namespace

void set_scales(const BuiltScene& scene, std::vector<display::ChannelDefinition>& channels) {
    const int light = beyond(brightest_light(scene)), length = beyond(extent(scene));
    for (display::ChannelDefinition& channel : channels) {
        if (!display::takes_samples(channel)) continue;
        if (channel.style == display::ChannelStyle::expression) channel.scale_exponent = light;
        else channel.scale_exponent = length * geoaovs::length_power(channel);
    }
    for (display::ChannelDefinition& channel : channels)
        if (!display::takes_samples(channel))
            channel.scale_exponent = channels[static_cast<std::size_t>(channel.source)].scale_exponent;
}

}  // namespace raylex::transport
