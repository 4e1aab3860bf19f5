#include "display/output/writer/deep_file.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <sstream>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepImageStateAttribute.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include "display/output/atomic_file.h"
#include "display/output/splits/stored_precision.h"
#include "display/output/writer/exr_header.h"
#include "display/output/writer/exr_pixels.h"

namespace raylex::display {

namespace {

constexpr int rows_at_once = 16;

/// The source of each plane's values: -3 Z, -2 ZBack, -1 A, otherwise a component of DeepSample::values.
struct DeepPlane {
    std::string name;
    int component = 0;
    StoredType type = StoredType::single_float;
    std::string layer = {};      // name of the channel
    bool needs_repairs = false;  // some values can be beyond the type
};

std::vector<DeepPlane> planes_of(const DeepBuffer& deep, ChannelId beauty, const DeepStorage& storage) {
    std::vector<DeepPlane> planes{{"Z", -3}, {"ZBack", -2}, {"A", -1}};
    int component = 0;
    for (const ChannelId id : deep.chosen()) {
        const ChannelDefinition& channel = deep.channels()[static_cast<std::size_t>(id)];
        const std::vector<ChannelDefinition> one{channel};
        std::vector<std::string> names = plan_parts(one, id == beauty ? 0 : invalid_channel, {}).front().planes;
        if (id == beauty) names.pop_back();  // A is already in the list
        const bool is_half = storage.half_color && kind_of(channel) == ChannelKind::light;
        // A colour is a sum of at most 2^(47 + scale), divided by a transmittance of at least 1e-15, about 2^-50.
        const bool needs_repairs = is_half || channel.scale_exponent > 127 - 47 - 50;
        for (const std::string& name : names)
            planes.push_back({name, component++, is_half ? StoredType::half_float : StoredType::single_float,
                              id == beauty ? "beauty" : channel.name, needs_repairs});
    }
    return planes;
}

Imf::Header deep_header(const DeepBuffer& deep, ChannelId beauty, const std::vector<DeepPlane>& planes,
                        const ImageDescription& description, const DeepStorage& storage) {
    Imf::Header header = base_header("deep", deep.width(), deep.height(), description);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = compression_of(storage.compression);
    for (const DeepPlane& plane : planes) header.channels().insert(plane.name, Imf::Channel(pixel_type(plane.type)));
    header.insert("deepImageState",
                  Imf::DeepImageStateAttribute(deep.options().tidy ? Imf::DIS_TIDY : Imf::DIS_SORTED));
    std::map<std::string, std::string> attributes = description.attributes;
    for (const ChannelId id : deep.chosen()) {
        const std::vector<ChannelDefinition> one{deep.channels()[static_cast<std::size_t>(id)]};
        const std::vector<PlannedPart> parts = plan_parts(one, id == beauty ? 0 : invalid_channel, {});
        for (const auto& [name, value] : parts.front().attributes)
            if (name.starts_with("lpe/") || name.starts_with("lpeDialect/") || name.starts_with("space/"))
                attributes[name] = value;
    }
    attributes["colorInteropID"] = color_interop_id(description.chromaticities);
    const DeepCounts counts = deep.counts();
    attributes["raylex/deepTolerance"] = std::to_string(deep.options().tolerance);
    attributes["raylex/deepMostSamples"] = std::to_string(deep.options().most_samples);
    attributes["raylex/deepMerged"] = std::to_string(counts.merged_pixels) +
                                      " pixels passed the limit; depths within " + std::to_string(counts.coarsest) +
                                      " of each other were merged there";
    if (!description.complete) attributes["raylex/incomplete"] = "true";
    attributes.emplace("software", "raylex");
    for (const auto& [name, value] : attributes) header.insert(name, Imf::StringAttribute(value));
    return header;
}

float stored_value(const DeepSample& sample, const DeepPlane& plane, Repairs& repairs) {
    switch (plane.component) {
        case -3:
            return sample.z;
        case -2:
            return sample.z_back;
        case -1:
            return sample.alpha;
        default:
            break;
    }
    const float value = sample.values[static_cast<std::size_t>(plane.component)];
    return repairs.to_stored(static_cast<double>(value), 0, plane.type);
}

/// The `repaired/NAME` attributes of layers with values that their planes cannot hold.
std::map<std::string, std::string> repaired_layers(const DeepBuffer& deep, std::vector<DeepPlane> planes) {
    std::erase_if(planes, [](const DeepPlane& plane) { return !plane.needs_repairs; });
    std::map<std::string, Repairs> repairs;
    for (int y = 0; y < deep.height() && !planes.empty(); ++y)
        for (int x = 0; x < deep.width(); ++x)
            for (const DeepSample& sample : deep.resolve(x, y))
                for (const DeepPlane& plane : planes) stored_value(sample, plane, repairs[plane.layer]);
    std::map<std::string, std::string> attributes;
    for (const DeepPlane& plane : planes)
        if (std::string text = repairs_text(repairs[plane.layer], plane.type); !text.empty())
            attributes["repaired/" + plane.layer] = std::move(text);
    return attributes;
}

/// A band of rows in OpenEXR's layout: counts and, per plane, a pointer for every pixel.
class Band {
  public:
    Band(const DeepBuffer& deep, const std::vector<DeepPlane>& planes, int y0, int y1) : width_(deep.width()), y0_(y0) {
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < deep.width(); ++x) pixels_.push_back(deep.resolve(x, y));
        std::size_t total = 0;
        for (const auto& samples : pixels_) {
            counts_.push_back(static_cast<unsigned>(samples.size()));
            total += samples.size();
        }
        for (const DeepPlane& plane : planes) add_plane(plane, total);
    }

    [[nodiscard]] Imf::DeepFrameBuffer frame_buffer(const std::vector<DeepPlane>& planes) {
        Imf::DeepFrameBuffer buffer;
        const auto before = static_cast<std::ptrdiff_t>(y0_) * width_;
        const auto stride = static_cast<std::size_t>(width_);
        buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts_.data() - before),
                                                 sizeof(unsigned), sizeof(unsigned) * stride));
        for (std::size_t p = 0; p < planes.size(); ++p)
            buffer.insert(
                planes[p].name,
                Imf::DeepSlice(pixel_type(planes[p].type), reinterpret_cast<char*>(pointers_[p].data() - before),
                               sizeof(char*), sizeof(char*) * stride, bytes_of(planes[p].type)));
        return buffer;
    }

  private:
    void add_plane(const DeepPlane& plane, std::size_t total) {
        const std::size_t size = bytes_of(plane.type);
        std::vector<char>& bytes = bytes_.emplace_back(total * size);
        std::vector<char*>& pointers = pointers_.emplace_back();
        std::size_t at = 0;
        Repairs repairs;  // repaired_layers() counts them
        for (const auto& samples : pixels_) {
            pointers.push_back(bytes.data() + at);
            for (const DeepSample& sample : samples) {
                const float value = stored_value(sample, plane, repairs);
                if (plane.type == StoredType::half_float) {
                    const std::uint16_t bits = half(value).bits();
                    std::memcpy(bytes.data() + at, &bits, 2);
                } else {
                    std::memcpy(bytes.data() + at, &value, 4);
                }
                at += size;
            }
        }
    }
    std::ptrdiff_t width_;
    int y0_;
    std::vector<std::vector<DeepSample>> pixels_;
    std::vector<unsigned> counts_;
    std::vector<std::vector<char>> bytes_;
    std::vector<std::vector<char*>> pointers_;
};

}  // namespace

Result<DeepStorage> parse_deep_storage(const std::string& text, const SourceLocation& where) {
    DeepStorage storage;
    std::istringstream words(text);
    bool any = false;
    for (std::string word; words >> word; any = true) {
        if (word == "half" || word == "float") storage.half_color = word == "half";
        else if (word == "none") storage.compression = ExrCompression::none;
        else if (word == "rle") storage.compression = ExrCompression::rle;
        else if (word == "zips") storage.compression = ExrCompression::zips;
        else
            return error_at(where, "'" + word +
                                       "' is not a storage for deep data; expected half or float, and one of none, "
                                       "rle, zips (OpenEXR has no other compression for it)");
    }
    if (!any) return error_at(where, "the storage of deep data is empty; expected, for example, 'half zips'");
    return storage;
}

Status write_deep_exr(const std::string& path, const DeepBuffer& deep, ChannelId beauty, ImageDescription description,
                      const DeepStorage& storage, std::map<std::string, std::string>* repaired) {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    try {
        start_encoder_threads();
        const std::vector<DeepPlane> planes = planes_of(deep, beauty, storage);
        std::map<std::string, std::string> repairs = repaired_layers(deep, planes);
        description.attributes.insert(repairs.begin(), repairs.end());
        if (repaired != nullptr) *repaired = std::move(repairs);
        HeaderRecorder stream(*file);
        stream.stop_recording();
        Imf::DeepScanLineOutputFile output(stream, deep_header(deep, beauty, planes, description, storage));
        for (int y = 0; y < deep.height(); y += rows_at_once) {
            const int end = std::min(y + rows_at_once, deep.height());
            Band band(deep, planes, y, end);
            output.setFrameBuffer(band.frame_buffer(planes));
            output.writePixels(end - y);
        }
    } catch (const std::exception& exception) {
        Error error = file->failed() ? file->failure() : Error{};
        if (!file->failed()) error.message = std::string("cannot write the deep image: ") + exception.what();
        error.file = path;
        return error;
    }
    return file->commit();
}

}  // namespace raylex::display
