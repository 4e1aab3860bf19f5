// Invariants that hold for every sample: exactly, or up to a bound on rounding.
#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/invariants/scene_under_test.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/scene/scene_hash.h"

namespace raylex::experiments {
namespace {

using transport::RenderOutput;
using transport::RenderSettings;
using transport::SceneDescription;

std::string record_bytes_of(const RenderOutput& output) {
    std::string bytes;
    output.frame_buffer.append_record(bytes);
    return bytes;
}

/// Returns 0 if the records of two renders have equal bytes, else the relative difference of the images.
Measured same_bits(const SceneUnderTest& test, const Result<RenderOutput>& other) {
    if (!other) return {true, 1, 0, "one render fails: " + other.error().message};
    if (record_bytes_of(*other) == record_bytes_of(*test.output)) return {};
    return {true, std::max(difference(*test.output, *other), 1e-300), 0, "relative difference of the images"};
}

/// Returns the quantum of light sums in the frame buffer: 2^-80, unless the scene's lights are above 2^20 or below
/// 2^-20.
double quantum_of(const transport::RenderOutput& output) {
    return std::ldexp(0x1p-80, output.frame_buffer.channels().front().scale_exponent);
}

/// Compares with the image of another scene that must give the same image.
Measured same_image(const SceneUnderTest& test, const SceneDescription& scene, double bound, double factor = 1) {
    const auto other = transport::render(scene, test.settings);
    if (!other) return Measured::skip("the variant is rejected: " + other.error().message);
    if (test.output->frame_buffer.rejected_count() + other->frame_buffer.rejected_count() +
            test.output->statistics.invalid_samples + other->statistics.invalid_samples >
        0)
        return Measured::skip("numbers leave the range of float");
    Measured result{true, 0, bound, "largest difference over the image's largest value"};
    for (std::size_t id = 0; id < test.light_channels(); ++id) {
        const auto a = test.output->frame_buffer.resolve(static_cast<display::ChannelId>(id));
        const auto b = other->frame_buffer.resolve(static_cast<display::ChannelId>(id));
        double largest = 0, apart = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            largest = std::max(largest, std::abs(b[i]));
            apart = std::max(apart, std::abs(a[i] * factor - b[i]));
        }
        // The rounding of at most a million splats to the frame buffer's quantum.
        const double rounding = 0x1p20 * std::max(quantum_of(*test.output) * factor, quantum_of(*other));
        if (apart > rounding) result.value = std::max(result.value, apart / largest);
    }
    return result;
}

Measured finite(const SceneUnderTest& test) {
    Measured result{true, 0, 0, "number of light values and AOV values that are not finite"};
    const display::FrameBuffer& buffer = test.output->frame_buffer;
    for (std::size_t id = 0; id < buffer.channels().size(); ++id)
        for (const double value : buffer.resolve(static_cast<display::ChannelId>(id)))
            result.value += (id < test.light_channels() ? std::isfinite(value) : !std::isnan(value)) ? 0 : 1;
    return result;
}

/// Counts numbers that the renderer rejected. In wild scenes overflow is expected.
Measured none_refused(const SceneUnderTest& test) {
    return {true, static_cast<double>(test.output->statistics.invalid_samples), 0,
            "contributions rejected as not finite"};
}

Measured non_negative(const SceneUnderTest& test) {
    if (test.filter_has_negative_lobes()) return Measured::skip("the pixel filter has negative lobes");
    if (test.built->view().materials->disperses())
        return Measured::skip("dispersive glass can give single wavelengths negative RGB values");
    Measured result{true, 0, 0, "the most negative value of light"};
    const display::FrameBuffer& buffer = test.output->frame_buffer;
    for (std::size_t id = 0; id < test.light_channels(); ++id)
        for (const double value : buffer.resolve(static_cast<display::ChannelId>(id)))
            result.value = std::max(result.value, -value);
    return result;
}

Measured split_sum(const SceneUnderTest& test) {
    const display::FrameBuffer& buffer = test.output->frame_buffer;
    if (buffer.rejected_count() + test.output->statistics.invalid_samples > 0)
        return Measured::skip("numbers leave the range of float, so layers can lack contributions");
    const std::vector<double> beauty = buffer.resolve(test.output->beauty);
    std::vector<double> sum(beauty.size()), size(beauty.size());
    // With negative lobes, samples of a pixel cancel, so the rest is compared with the samples' magnitude.
    double least = 0;
    if (test.filter_has_negative_lobes()) {
        RenderSettings positive = test.settings;
        positive.film.filter.emplace().type = "box";
        const auto other = transport::render(*test.built, positive);
        if (!other) return Measured::skip("rejected with a filter without negative lobes: " + other.error().message);
        for (const double value : other->frame_buffer.resolve(other->beauty)) least = std::max(least, value);
    }
    for (std::size_t i = 0; i < test.layers; ++i) {
        const auto values = buffer.resolve(test.output->beauty + 1 + static_cast<display::ChannelId>(i));
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += values[k], size[k] += std::abs(values[k]);
    }
    Measured result{true, 0, 1e-12, "|sum of layers - beauty| relative to the sum of their magnitudes (Law 1)"};
    for (std::size_t k = 0; k < sum.size(); ++k) {
        const double apart = std::abs(sum[k] - beauty[k]), whole = std::max(size[k] + std::abs(beauty[k]), least);
        if (apart > 0x1p10 * quantum_of(*test.output)) result.value = std::max(result.value, apart / whole);
    }
    return result;
}

Measured threads(const SceneUnderTest& test) {
    RenderSettings settings = test.settings;
    settings.machine.threads = 3;
    return same_bits(test, transport::render(*test.built, settings));
}

Measured shards(const SceneUnderTest& test) {
    RenderSettings settings = test.settings;
    constexpr std::uint64_t block = 16;
    settings.samples.per_pixel = 2 * block - 3;
    auto whole = transport::render(*test.built, settings);
    if (!whole) return Measured::skip("refused: " + whole.error().message);
    RenderSettings first = settings, second = settings;
    first.samples.per_pixel = block;
    second.samples.first = block;
    auto a = transport::render(*test.built, first);
    const auto b = transport::render(*test.built, second);
    if (!a || !b) return Measured::skip("this integrator does not support shards");
    if (Status merged = a->frame_buffer.merge(b->frame_buffer); !merged)
        return {true, 1, 0, "the shards do not merge: " + merged.error().message};
    if (record_bytes_of(*a) == record_bytes_of(*whole)) return {};
    return {true, std::max(difference(*a, *whole), 1e-300), 0, "relative difference of the images"};
}

Measured asking(const SceneUnderTest& test) {
    RenderSettings settings = test.settings;
    settings.channels.list.clear();
    const auto other = transport::render(*test.built, settings);
    if (!other) return {true, 1, 0, "rejected without layers: " + other.error().message};
    const auto with = test.output->frame_buffer.resolve(test.output->beauty),
               without = other->frame_buffer.resolve(other->beauty);
    Measured result{true, 0, 0, "difference from the beauty of a render without layers"};
    for (std::size_t i = 0; i < with.size(); ++i) result.value = std::max(result.value, std::abs(with[i] - without[i]));
    return result;
}

Measured crop(const SceneUnderTest& test) {
    RenderSettings settings = test.settings;
    const int width = test.output->view.width, height = test.output->view.height;
    settings.film.crop = display::PixelRegion{width / 3, height / 3, width - width / 3, height - height / 3};
    const auto other = transport::render(*test.built, settings);
    if (!other) return Measured::skip("refused: " + other.error().message);
    const auto whole = test.output->frame_buffer.resolve(test.output->beauty),
               part = other->frame_buffer.resolve(other->beauty);
    Measured result{true, 0, 0, "difference from the pixels of the whole image"};
    for (int y = settings.film.crop->y0; y < settings.film.crop->y1; ++y)
        for (int x = settings.film.crop->x0; x < settings.film.crop->x1; ++x)
            for (int c = 0; c < 3; ++c) {
                const auto i = static_cast<std::size_t>(3 * (y * width + x) + c);
                result.value = std::max(result.value, std::abs(whole[i] - part[i]));
            }
    return result;
}

Measured write_import(const SceneUnderTest& test) {
    const transport::PbrtText written = transport::pbrt_text(test.scene);
    if (!written.meshes.empty()) return Measured::skip("meshes are in files: raylex scene write");
    auto again = transport::import_pbrt_text(written.text, test.path);
    if (!again) return {true, 1, 0, "the written scene is rejected: " + again.error().to_string()};
    const bool shared = again->materials.size() == test.scene.materials.size() &&
                        again->area_lights.size() == test.scene.area_lights.size();
    if (shared && transport::scene_hash(*again) != transport::scene_hash(test.scene))
        return {true, 1, 0, "the written scene is different"};
    return same_bits(test, transport::render(*again, test.settings));
}

Measured unit_of_length(const SceneUnderTest& test) {
    // The probability of choosing a sky among lights depends on the size of the scene.
    if (test.scene.shapes.empty() && test.scene.instances.empty()) return Measured::skip("the scene has no size");
    return same_image(test, scaled(test.scene, 4), 0);
}

Measured unit_of_light(const SceneUnderTest& test) {
    double largest = 0;
    for (const double value : test.output->frame_buffer.resolve(test.output->beauty))
        largest = std::max(largest, std::abs(value));
    // Intermediate products can be an eighth of the result; below 2^-126 they lose bits.
    if (largest < 0x1p-76) return Measured::skip("the image is within a factor of 2^50 of the smallest float");
    if (!can_be_brightened(test.scene))
        return Measured::skip("the light of a grid depends on temperatures or a spectrum");
    return same_image(test, brightened(test.scene, 8), 0, 8);
}

Measured constant_texture(const SceneUnderTest& test) {
    return same_image(test, textured(test.scene), 0);
}

}  // namespace

const std::vector<Invariant>& invariants_of_bits() {
    static const std::vector<Invariant> all{
        {{"finite", "every value of light is a finite number", false, false}, finite},
        {{"none-refused", "no sample is NaN or infinite (scenes of ordinary size)", false, true}, none_refused},
        {{"non-negative", "no value of light is below 0 (filters without negative lobes)", false, false}, non_negative},
        {{"split-sum", "layers that split the light sum to the beauty within 1e-12", false, false}, split_sum},
        {{"threads", "3 threads give the bits of one", false, false}, threads},
        {{"shards", "two shards merge to the bits of the whole", false, false}, shards},
        {{"asking", "the beauty has the same bits with and without layers", false, false}, asking},
        {{"crop", "a crop has the bits of the whole image", false, false}, crop},
        {{"write-import", "writing the scene as pbrt text and reading it gives the same scene and image", false, false},
         write_import},
        {{"unit-of-length", "a unit of length 4 times as long gives the same image, to the bit", false, true},
         unit_of_length},
        {{"unit-of-light", "8 times the light is 8 times the image, to the bit", false, false}, unit_of_light},
        {{"constant-texture", "a texture of one value equals the value, to the bit", false, false}, constant_texture},
    };
    return all;
}

}  // namespace raylex::experiments
