#include "display/output/reader/exr_reader.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <thread>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include "display/output/color/primaries.h"
#include "display/output/reader/exr_guard.h"
#include "display/output/reader/exr_layers.h"
#include "display/output/reader/exr_loss.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

struct Window {
    std::int64_t min_x, min_y, width, height;
};

Window window_of(const Imath::Box2i& box) {
    return {box.min.x, box.min.y, std::int64_t{box.max.x} - box.min.x + 1, std::int64_t{box.max.y} - box.min.y + 1};
}

bool is_deep(const Imf::Header& header) {
    return header.hasType() && !Imf::isImage(header.type());
}

// A damaged or hostile header can claim any size; never allocate memory that the machine does not have.
Status check_size(const ExrBands& file) {
    const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
    const double needed = file.bytes_at_once();
    if (needed <= memory) return success();
    return error_at({file.image().path, 0, 0}, "the header declares " +
                                                   std::to_string(static_cast<std::int64_t>(needed / 1e9)) +
                                                   " GB of pixels, more than this machine's memory of " +
                                                   std::to_string(static_cast<std::int64_t>(memory / 1e9)) +
                                                   " GB; expected a smaller image (is the file damaged?)");
}

StoredType stored_type(Imf::PixelType type) {
    return type == Imf::HALF    ? StoredType::half_float
           : type == Imf::FLOAT ? StoredType::single_float
                                : StoredType::unsigned_int;
}

// Copies the (possibly subsampled) data window to the display window; uncovered pixels are 0.
std::vector<float> to_display_window(std::vector<float> samples, const Window& data, const Window& display,
                                     int x_sampling, int y_sampling) {
    const bool same = data.min_x == display.min_x && data.min_y == display.min_y && data.width == display.width &&
                      data.height == display.height;
    if (same && x_sampling == 1 && y_sampling == 1) return samples;
    std::vector<float> result(static_cast<std::size_t>(display.width * display.height), 0.0f);
    const std::int64_t stride = (data.width + x_sampling - 1) / x_sampling;
    const std::int64_t first_x = std::max(data.min_x, display.min_x),
                       last_x = std::min(data.min_x + data.width, display.min_x + display.width);
    const std::int64_t first_y = std::max(data.min_y, display.min_y),
                       last_y = std::min(data.min_y + data.height, display.min_y + display.height);
    for (std::int64_t y = first_y; y < last_y; ++y)
        for (std::int64_t x = first_x; x < last_x; ++x)
            result[static_cast<std::size_t>((y - display.min_y) * display.width + x - display.min_x)] =
                samples[static_cast<std::size_t>((y - data.min_y) / y_sampling * stride +
                                                 (x - data.min_x) / x_sampling)];
    return result;
}

/// Reads rows [rows.first, rows.end) of the display window; all rows if a channel is vertically subsampled.
FilePart read_part(Imf::MultiPartInputFile& file, int index, const RowRange& rows) {
    const Imf::Header& header = file.header(index);
    Window data = window_of(header.dataWindow()), display = window_of(header.displayWindow());
    display = {display.min_x, display.min_y + rows.first, display.width, rows.end - rows.first};
    if (rows.end - rows.first < window_of(header.displayWindow()).height) {
        const std::int64_t first = std::max(data.min_y, display.min_y),
                           end = std::min(data.min_y + data.height, display.min_y + display.height);
        data = {data.min_x, first, data.width, std::max<std::int64_t>(end - first, 0)};
    }
    struct Raw {
        const char* name;
        Imf::Channel channel;
        std::vector<float> samples;
    };
    std::vector<Raw> raw;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        raw.push_back({c.name(), c.channel(), {}});

    Imf::FrameBuffer buffer;
    for (Raw& each : raw) {
        const std::int64_t xs = each.channel.xSampling, ys = each.channel.ySampling;
        const std::int64_t width = (data.width + xs - 1) / xs, height = (data.height + ys - 1) / ys;
        each.samples.resize(static_cast<std::size_t>(width * height));
        // The library needs the address of pixel (0, 0), which can be outside the array. The code uses integer
        // arithmetic, because such a pointer must not be formed.
        const std::intptr_t origin =
            reinterpret_cast<std::intptr_t>(each.samples.data()) - 4 * (data.min_x / xs + data.min_y / ys * width);
        buffer.insert(each.name,
                      Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), 4, static_cast<std::size_t>(4 * width),
                                 each.channel.xSampling, each.channel.ySampling));
    }
    if (data.height > 0) {
        Imf::InputPart part(file, index);
        part.setFrameBuffer(buffer);
        part.readPixels(static_cast<int>(data.min_y), static_cast<int>(data.min_y + data.height - 1));
    }

    FilePart result{header.hasName() ? header.name() : "", {}};
    for (Raw& each : raw)
        result.channels.push_back(
            {each.name, stored_type(each.channel.type),
             to_display_window(std::move(each.samples), data, display, each.channel.xSampling, each.channel.ySampling),
             plane_loss(header, each.name, each.channel.type), dwa_level(header), index, each.name});
    return result;
}

/// Describes the part without its pixels.
FilePart described_part(const Imf::Header& header, int index) {
    FilePart part{header.hasName() ? header.name() : "", {}};
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        part.channels.push_back({c.name(),
                                 stored_type(c.channel().type),
                                 {},
                                 plane_loss(header, c.name(), c.channel().type),
                                 dwa_level(header),
                                 index,
                                 c.name()});
    return part;
}

int lines_unpacked_together(const Imf::Header& header) {
    switch (header.compression()) {
        case Imf::ZIP_COMPRESSION:
        case Imf::PXR24_COMPRESSION:
            return 16;
        case Imf::PIZ_COMPRESSION:
        case Imf::B44_COMPRESSION:
        case Imf::B44A_COMPRESSION:
        case Imf::DWAA_COMPRESSION:
            return 32;
        case Imf::DWAB_COMPRESSION:
            return 256;
        default:
            return 1;
    }
}

void read_attributes(const Imf::Header& header, ExrImage& image) {
    for (auto i = header.begin(); i != header.end(); ++i) {
        const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute());
        const std::string name = i.name();
        if (text == nullptr || name == "name" || name == "type" || name == "view") continue;
        const bool fresh = image.attributes.emplace(name, text->value()).second;
        constexpr std::string_view prefix = "partition/";
        if (fresh && name.starts_with(prefix))
            image.partitions.push_back(parse_partition(name.substr(prefix.size()), text->value()));
    }
    if (!image.chromaticities && Imf::hasChromaticities(header)) {
        const Imf::Chromaticities& c = Imf::chromaticities(header);
        const auto xy = [](const Imath::V2f& v) { return std::array<double, 2>{v.x, v.y}; };
        const Chromaticities primaries{xy(c.red), xy(c.green), xy(c.blue), xy(c.white)};
        // Some writers leave zeros there: collinear primaries, or a white without luminance, are meaningless.
        if (primaries.white[1] > 1e-3 && inverse(rgb_to_xyz(primaries)) != Matrix3{}) image.chromaticities = primaries;
    }
}

/// Returns the result of `read`, or converts its exception to an Error.
template <class Read>
auto guarded(const std::string& path, Read read) -> decltype(read()) {
    try {
        return read();
    } catch (const std::bad_alloc&) {
        return error_at({path, 0, 0}, "not enough memory for the image");
    } catch (const std::exception& exception) {
        return error_at({path, 0, 0}, std::string("the file is truncated or damaged: ") + exception.what() +
                                          "; expected a whole OpenEXR file");
    } catch (...) { return error_at({path, 0, 0}, "the file is truncated or damaged; expected a whole OpenEXR file"); }
}

// "shot_diffuse.0001.exr" -> "shot_diffuse"
std::string base_name(const std::string& path) {
    std::string stem = std::filesystem::path(path).stem().string();
    const std::size_t dot = stem.rfind('.');
    if (dot != std::string::npos && dot != 0 && dot + 1 < stem.size() &&
        stem.find_first_not_of("0123456789", dot + 1) == std::string::npos)
        stem.erase(dot);
    return stem;
}

std::string size_text(const ExrImage& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

/// The library reads the parts of an open file sequentially, so each thread opens the file itself and reads its own
/// parts.
struct ExrBands::File {
    std::vector<std::unique_ptr<Imf::MultiPartInputFile>> handles;
    std::vector<int> flat;  // parts
    int lines = 1;          // lines that are unpacked together
    bool every_row = true;  // no channel is vertically subsampled
    std::uint64_t bytes_per_row = 0;
    double bytes_at_once = 0;  // for the whole image, in the file and in the display window
};

ExrBands::ExrBands() : file_(std::make_unique<File>()) {}
ExrBands::ExrBands(ExrBands&&) noexcept = default;
ExrBands& ExrBands::operator=(ExrBands&&) noexcept = default;
ExrBands::~ExrBands() = default;

namespace {

/// Describes one part: attributes and size. Returns an error if they are invalid.
Status describe_part(const std::string& path, Imf::MultiPartInputFile& file, int index, bool first, ExrImage& image) {
    const Imf::Header& header = file.header(index);
    if (!file.partComplete(index))
        return error_at({path, 0, 0}, "the image is incomplete: part " + std::to_string(index) +
                                          " lacks pixels (an interrupted write, or the file was cut); " +
                                          "expected a whole file");
    const Window display = window_of(header.displayWindow());
    if (first) {
        image.width = static_cast<int>(display.width);
        image.height = static_cast<int>(display.height);
        const Window data = window_of(header.dataWindow());
        const auto within = [](std::int64_t at, std::int64_t most) {
            return static_cast<int>(std::clamp<std::int64_t>(at, 0, most));
        };
        const std::int64_t x = data.min_x - display.min_x, y = data.min_y - display.min_y;
        const PixelRegion region{within(x, display.width), within(y, display.height),
                                 within(x + data.width, display.width), within(y + data.height, display.height)};
        if (region.width() < image.width || region.height() < image.height) image.data_window = region;
    } else if (display.width != image.width || display.height != image.height) {
        return error_at({path, 0, 0},
                        "part " + std::to_string(index) +
                            " and part 0 have different sizes; expected one display window for all parts");
    }
    read_attributes(header, image);
    return success();
}

}  // namespace

Result<ExrBands> ExrBands::open(const std::string& path) {
    if (Status sound = check_exr_file(path); !sound) return std::move(sound).error();
    return guarded(path, [&]() -> Result<ExrBands> {
        // Unpacking a small file takes less time than waking threads for its lines.
        constexpr std::uintmax_t small = std::uintmax_t{1} << 22;
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
        const bool is_small = !unknown && bytes < small;
        ExrBands bands;
        File& of = *bands.file_;
        bands.image_.path = path;
        of.handles.push_back(
            std::make_unique<Imf::MultiPartInputFile>(path.c_str(), is_small ? 0 : Imf::globalThreadCount()));
        Imf::MultiPartInputFile& file = *of.handles.front();
        std::vector<FilePart> parts;
        for (int i = 0; i < file.parts(); ++i) {
            const Imf::Header& header = file.header(i);
            if (is_deep(header)) continue;
            if (Status s = describe_part(path, file, i, of.flat.empty(), bands.image_); !s) return s.error();
            of.flat.push_back(i);
            of.lines = std::max(of.lines, lines_unpacked_together(header));
            const Window data = window_of(header.dataWindow());
            const auto width = static_cast<double>(bands.image_.width),
                       height = static_cast<double>(bands.image_.height);
            for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
                of.every_row = of.every_row && c.channel().ySampling == 1;
                of.bytes_per_row +=
                    4 * static_cast<std::uint64_t>(std::max<std::int64_t>(data.width, bands.image_.width));
                of.bytes_at_once +=
                    4 * (static_cast<double>(data.width) * static_cast<double>(data.height) + width * height);
            }
            parts.push_back(described_part(header, i));
        }
        if (of.flat.empty())
            return error_at({path, 0, 0}, "the file contains only deep images; expected at least one flat part");
        bands.image_.layers = name_layers(std::move(parts));
        if (of.flat.size() > 1 && !is_small) {
            const std::size_t threads =
                std::min(of.flat.size(), static_cast<std::size_t>(std::max(1u, std::thread::hardware_concurrency())));
            of.handles.clear();
            for (std::size_t i = 0; i < threads; ++i)
                of.handles.push_back(std::make_unique<Imf::MultiPartInputFile>(path.c_str(), 0));
        }
        return bands;
    });
}

double ExrBands::bytes_at_once() const {
    return file_->bytes_at_once;
}

std::vector<RowRange> ExrBands::bands(std::uint64_t bytes) const {
    const auto height = static_cast<std::uint64_t>(image_.height);
    const std::uint64_t lines = static_cast<std::uint64_t>(file_->lines);
    std::uint64_t rows = std::max<std::uint64_t>(1, bytes / std::max<std::uint64_t>(1, file_->bytes_per_row));
    if (rows > lines) rows -= rows % lines;
    if (!file_->every_row) rows = height;
    return bands_of({0, image_.height}, static_cast<int>(std::min(rows, height)));
}

Result<ExrImage> ExrBands::read(const RowRange& rows) const {
    return guarded(image_.path, [&]() -> Result<ExrImage> {
        const std::size_t threads = file_->handles.size();
        std::vector<FilePart> parts(file_->flat.size());
        const auto read = [&](std::size_t thread) {
            for (std::size_t i = thread; i < parts.size(); i += threads)
                parts[i] = read_part(*file_->handles[thread], file_->flat[i], rows);
        };
        std::vector<std::future<void>> readers;
        // If no thread can start, get() reads.
        const auto when = std::launch::async | std::launch::deferred;
        for (std::size_t i = 1; i < threads; ++i) readers.push_back(std::async(when, read, i));
        read(0);
        for (std::future<void>& reader : readers) reader.get();
        ExrImage image;
        image.path = image_.path;
        image.width = image_.width;
        image.height = rows.end - rows.first;
        if (image.height == image_.height) image.data_window = image_.data_window;
        image.attributes = image_.attributes;
        image.chromaticities = image_.chromaticities;
        image.partitions = image_.partitions;
        image.layers = name_layers(std::move(parts));
        return image;
    });
}

Result<ExrImage> read_exr(const std::string& path) {
    auto bands = ExrBands::open(path);
    if (!bands) return bands.error();
    if (Status size = check_size(*bands); !size) return size.error();
    return bands->read({0, bands->image().height});
}

Result<ExrImage> read_exr_set(const std::vector<std::string>& paths) {
    if (paths.empty()) return error_at({"", 0, 0}, "no image file given; expected at least one");
    if (paths.size() == 1) return read_exr(paths.front());
    ExrImage set;
    for (const std::string& path : paths) {
        Result<ExrImage> image = read_exr(path);
        if (!image) return std::move(image).error();
        if (&path == &paths.front()) {
            set.path = path;
            set.width = image->width;
            set.height = image->height;
            set.chromaticities = image->chromaticities;
        }
        if (image->width != set.width || image->height != set.height)
            return error_at({path, 0, 0}, "the image has " + size_text(*image) + " pixels; expected " + size_text(set) +
                                              " as in " + set.path);
        if (image->chromaticities != set.chromaticities)
            return error_at({path, 0, 0}, "the image has different chromaticities; expected those of " + set.path);
        const std::string base = base_name(path);
        for (ImageLayer& layer : image->layers) {
            const auto taken = [&set](const std::string& name) {
                return std::any_of(set.layers.begin(), set.layers.end(),
                                   [&name](const ImageLayer& each) { return each.name == name; });
            };
            if (layer.name.empty()) layer.name = base;
            else if (taken(layer.name)) layer.name = base + "." + layer.name;
            if (taken(layer.name))
                return error_at({path, 0, 0}, "two files give a layer called '" + layer.name +
                                                  "'; expected file names that give different layer names");
            set.layers.push_back(std::move(layer));
        }
        set.attributes.merge(image->attributes);
        set.partitions.insert(set.partitions.end(), image->partitions.begin(), image->partitions.end());
    }
    return set;
}

}  // namespace raylex::display
