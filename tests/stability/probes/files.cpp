// The precision of values in image files.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "display/output/reader/exr_reader.h"
#include "display/output/writer/exr_writer.h"
#include "tests/stability/probes/probes.h"

namespace raylex::experiments {
namespace {

constexpr int ramp_pixels = 1024;

/// An image of one row whose light rises from one power of two to the next.
class Ramp final : public display::PixelImage {
  public:
    explicit Ramp(double from) : from_(from) {
        channel_.name = "beauty";
        channel_.style = display::ChannelStyle::expression;
    }
    [[nodiscard]] const display::FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const display::ChannelDefinition> channels() const override { return {&channel_, 1}; }
    [[nodiscard]] std::vector<double> resolve(display::ChannelId, const display::PixelRegion& region) const override {
        std::vector<double> values;
        for (int y = region.y0; y < region.y1; ++y)
            for (int x = region.x0; x < region.x1; ++x) values.insert(values.end(), 3, value(x));
        return values;
    }
    [[nodiscard]] std::vector<double> resolve_alpha(const display::PixelRegion& region) const override {
        return std::vector<double>(std::size_t(region.width()) * std::size_t(region.height()), 1.0);
    }
    using display::PixelImage::resolve;
    using display::PixelImage::resolve_alpha;
    /// Returns values that are not multiples of the last place of a half.
    [[nodiscard]] double value(int x) const {
        return static_cast<float>(from_ * (1 + (double(x) + 1.0 / 3) / ramp_pixels));
    }

  private:
    double from_;
    display::FrameBufferLayout layout_{ramp_pixels, 1};
    display::ChannelDefinition channel_;
};

/// A temporary file, removed at the end.
class ScratchFile {
  public:
    ScratchFile() : folder_((std::filesystem::temp_directory_path() / "raylex-XXXXXX").string()) {
        made_ = mkdtemp(folder_.data()) != nullptr;
    }
    ~ScratchFile() {
        std::error_code failed;
        if (made_) std::filesystem::remove_all(folder_, failed);
    }
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    [[nodiscard]] std::string path() const { return folder_ + "/a.exr"; }

  private:
    std::string folder_;
    bool made_ = false;
};

Result<ProbeResult> stored_error(const ProbeInput& input) {
    const Ramp ramp(input.number("from"));
    display::ImageDescription description;
    if (Status chosen =
            display::override_exr_storage(description.storage, "light", input.word("storage"), input.where());
        !chosen)
        return chosen.error();
    const ScratchFile file;
    if (Status written = display::write_exr(file.path(), ramp, 0, description); !written) return written.error();
    auto image = display::read_exr(file.path());
    if (!image) return image.error();
    const display::ImageLayer* layer = image->layer("beauty");
    if (layer == nullptr) return error_at(input.where(), "the file has no beauty");
    ProbeResult result;
    result.expected = 0;
    for (int x = 0; x < ramp_pixels; ++x) {
        const double stored = double(layer->triple()[0]->values[static_cast<std::size_t>(x)]);
        result.measured = std::max(result.measured, std::abs(stored - ramp.value(x)) / ramp.value(x));
    }
    return result;
}

}  // namespace

std::span<const NamedProbe> file_probes() {
    static constexpr NamedProbe table[] = {
        {"stored_error",
         "largest relative error of light between two powers of two after writing to OpenEXR and reading; from, "
         "storage (float zip, half piz ...)",
         stored_error}};
    return table;
}

}  // namespace raylex::experiments
