#include "display/output/exr_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <thread>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include "display/output/atomic_file.h"
#include "display/output/exr_layout.h"

namespace raylex::display {

namespace {

// OpenEXR's view of an AtomicFile. The first failure is thrown, later writes are swallowed: the library's destructors
// write too, and whoever asks the file afterwards learns the reason.
class FileStream : public Imf::OStream {
  public:
    explicit FileStream(AtomicFile& file) : Imf::OStream(file.target().c_str()), file_(file) {}
    void write(const char bytes[], int count) override {
        check(file_.failed() || file_.write(bytes, static_cast<std::size_t>(count)));
    }
    std::uint64_t tellp() override { return file_.position(); }
    void seekp(std::uint64_t position) override { check(file_.failed() || file_.seek(position)); }

  private:
    static void check(bool good) {
        if (!good) throw std::runtime_error("writing failed");
    }
    AtomicFile& file_;
};

struct Repairs {
    std::size_t not_a_number = 0, out_of_range = 0;

    float to_float(double value, float miss) {
        constexpr double largest = std::numeric_limits<float>::max();
        if (std::abs(value) <= largest) return static_cast<float>(value);
        if (std::isnan(value)) {
            ++not_a_number;
            return 0.0f;
        }
        if (std::isinf(miss) && value == static_cast<double>(miss)) return miss;
        ++out_of_range;
        return value > 0 ? std::numeric_limits<float>::max() : std::numeric_limits<float>::lowest();
    }
};

// Light is summed in fixed point, so it is finite; what is picked (depth, normals) is whatever was written.
bool may_need_repair(const ChannelDefinition& channel) {
    return channel.type != ChannelType::integer && channel.rule != FilterRule::filter &&
           channel.rule != FilterRule::average && channel.rule != FilterRule::sum;
}

void note_repairs(const FrameBuffer& frame_buffer, std::vector<PlannedPart>& parts) {
    for (PlannedPart& part : parts) {
        const ChannelDefinition& channel = frame_buffer.channels()[static_cast<std::size_t>(part.channel)];
        if (!may_need_repair(channel)) continue;
        Repairs repairs;
        for (const double value : frame_buffer.resolve(part.channel)) repairs.to_float(value, channel.miss_value);
        if (repairs.not_a_number + repairs.out_of_range == 0) continue;
        const std::string text = std::to_string(repairs.not_a_number) + " values not a number, set to 0; " +
                                 std::to_string(repairs.out_of_range) + " beyond float, set to the largest";
        part.attributes["repaired/" + channel.name] = text;
        parts.front().attributes["repaired/" + channel.name] = text;
    }
}

bool is_zero(const std::array<std::array<double, 4>, 4>& matrix) {
    return matrix == std::array<std::array<double, 4>, 4>{};
}

// Imath multiplies row vectors from the left, so its matrices are the transposed of ours.
Imath::M44f transposed(const std::array<std::array<double, 4>, 4>& matrix) {
    Imath::M44f result;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            result[j][i] = static_cast<float>(matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
    return result;
}

// OpenEXR's NDC: (0, 0) is the upper left corner of the image and (1, 1) the lower right (ImfStandardAttributes.h).
std::array<std::array<double, 4>, 4> screen_to_ndc(std::array<std::array<double, 4>, 4> matrix) {
    for (std::size_t j = 0; j < 4; ++j) {
        matrix[0][j] = 0.5 * (matrix[3][j] + matrix[0][j]);
        matrix[1][j] = 0.5 * (matrix[3][j] - matrix[1][j]);
    }
    return matrix;
}

Imf::Header make_header(const PlannedPart& part, const FrameBufferLayout& layout, const ImageDescription& description) {
    Imf::Header header(layout.width, layout.height);
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const std::string& plane : part.planes)
        header.channels().insert(plane, Imf::Channel(part.integer ? Imf::UINT : Imf::FLOAT));
    const auto xy = [](const std::array<double, 2>& p) {
        return Imath::V2f(static_cast<float>(p[0]), static_cast<float>(p[1]));
    };
    const Chromaticities& c = description.chromaticities;
    Imf::addChromaticities(header, Imf::Chromaticities(xy(c.red), xy(c.green), xy(c.blue), xy(c.white)));
    if (!is_zero(description.world_to_camera)) Imf::addWorldToCamera(header, transposed(description.world_to_camera));
    if (!is_zero(description.world_to_screen))
        Imf::addWorldToNDC(header, transposed(screen_to_ndc(description.world_to_screen)));
    for (const auto& [name, value] : part.attributes) header.insert(name, Imf::StringAttribute(value));
    return header;
}

// The 4-byte values of a part, plane after plane.
std::vector<std::uint32_t> part_values(const FrameBuffer& frame_buffer, const PlannedPart& part) {
    const ChannelDefinition& channel = frame_buffer.channels()[static_cast<std::size_t>(part.channel)];
    const auto components = static_cast<std::size_t>(component_count(channel.type));
    const std::vector<double> pixels = frame_buffer.resolve(part.channel);
    const std::size_t count = pixels.size() / components;
    std::vector<std::uint32_t> values(count * part.planes.size());
    Repairs repairs;
    for (std::size_t c = 0; c < components; ++c)
        for (std::size_t i = 0; i < count; ++i) {
            const double value = pixels[i * components + c];
            values[c * count + i] =
                part.integer ? static_cast<std::uint32_t>(std::isfinite(value) ? static_cast<std::int64_t>(value) : 0)
                             : std::bit_cast<std::uint32_t>(repairs.to_float(value, channel.miss_value));
        }
    if (part.alpha) {
        const std::vector<double> alpha = frame_buffer.resolve_alpha();
        for (std::size_t i = 0; i < count; ++i)
            values[components * count + i] = std::bit_cast<std::uint32_t>(repairs.to_float(alpha[i], 0));
    }
    return values;
}

void write_parts(AtomicFile& file, const FrameBuffer& frame_buffer, const std::vector<PlannedPart>& parts,
                 const ImageDescription& description) {
    const FrameBufferLayout& layout = frame_buffer.layout();
    std::vector<Imf::Header> headers;
    for (const PlannedPart& part : parts) headers.push_back(make_header(part, layout, description));
    // Compression is most of the work; the pool lives on for other files.
    if (Imf::globalThreadCount() == 0)
        Imf::setGlobalThreadCount(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
    FileStream stream(file);
    Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < parts.size(); ++i) {
        std::vector<std::uint32_t> values = part_values(frame_buffer, parts[i]);
        const std::size_t plane_size = values.size() / parts[i].planes.size();
        Imf::FrameBuffer buffer;
        for (std::size_t p = 0; p < parts[i].planes.size(); ++p)
            buffer.insert(parts[i].planes[p], Imf::Slice(parts[i].integer ? Imf::UINT : Imf::FLOAT,
                                                         reinterpret_cast<char*>(values.data() + p * plane_size), 4,
                                                         4 * static_cast<std::size_t>(layout.width)));
        Imf::OutputPart part(output, static_cast<int>(i));
        part.setFrameBuffer(buffer);
        part.writePixels(layout.height);
    }
}

}  // namespace

Status write_exr(const std::string& path, const FrameBuffer& frame_buffer, ChannelId beauty,
                 const ImageDescription& description) {
    const auto located = [&path](Error error) {
        error.file = path;
        return error;
    };
    if (Status names = check_channel_names(frame_buffer.channels(), beauty); !names)
        return located(std::move(names).error());
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    try {
        std::vector<PlannedPart> parts = plan_parts(frame_buffer.channels(), beauty, description);
        note_repairs(frame_buffer, parts);
        write_parts(*file, frame_buffer, parts, description);
    } catch (const std::exception& exception) {
        if (file->failed()) return located(file->failure());
        Error error;
        error.message = std::string("cannot write the image: ") + exception.what();
        return located(error);
    }
    return file->commit();
}

}  // namespace raylex::display
