#include "display/output/writer/deep_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <stdexcept>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>

#include "display/output/reader/exr_guard.h"
#include "display/output/splits/stored_precision.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

/// A shallow plane and the deep channel that must flatten to it.
struct Pair {
    const ImagePlane* shallow = nullptr;
    std::string channel;
    StoredType type = StoredType::single_float;  // type of the deep channel
};

struct Comparison {
    const ImagePlane* alpha = nullptr;
    std::vector<Pair> pairs;
    std::vector<std::string> layers;
};

Comparison match(const Imf::ChannelList& channels, const ExrImage& image) {
    Comparison result;
    for (const ImageLayer& layer : image.layers) {
        bool any = false;
        for (const ImagePlane& plane : layer.planes) {
            if (layer.name.empty() && plane.name == "A") {
                result.alpha = &plane;
                continue;
            }
            if (plane.name == "Z" && layer.planes.size() == 1) continue;  // depth does not flatten to one value
            const std::string single = layer.planes.size() == 1 ? layer.name : layer.name + "." + plane.name;
            const std::string name = layer.name.empty() ? plane.name : single;
            const Imf::Channel* channel = channels.findChannel(name);
            if (channel == nullptr) continue;
            result.pairs.push_back(
                {&plane, name, channel->type == Imf::HALF ? StoredType::half_float : StoredType::single_float});
            any = true;
        }
        if (any) result.layers.push_back(layer.name.empty() ? "beauty" : layer.name);
    }
    return result;
}

/// A damaged count must not allocate memory that no valid row needs.
constexpr std::size_t most_row_samples = std::size_t{1} << 26;

/// One row of a deep file, plane after plane. Without ZBack, `names` contains Z twice, and the front serves as the
/// back.
class DeepRow {
  public:
    DeepRow(int width, const std::vector<std::string>& names) : counts_(static_cast<std::size_t>(width)) {
        for (std::size_t i = 0; i < names.size(); ++i) {
            pointers_.emplace_back(static_cast<std::size_t>(width));
            values_.emplace_back();
        }
        names_ = names;
    }
    void read(Imf::DeepScanLineInputPart& part, int y, int min_x) {
        Imf::DeepFrameBuffer buffer;
        buffer.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts_.data() - min_x), sizeof(unsigned), 0));
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (i == 1 && names_[1] == names_[0]) continue;  // no ZBack: see below
            buffer.insert(names_[i], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers_[i].data() - min_x),
                                                    sizeof(float*), 0, sizeof(float)));
        }
        part.setFrameBuffer(buffer);
        part.readPixelSampleCounts(y, y);
        std::size_t total = 0;
        for (const unsigned count : counts_) total += count;
        if (total > most_row_samples) throw std::runtime_error("a row claims more samples than any image can have");
        for (std::size_t i = 0; i < names_.size(); ++i) {
            values_[i].resize(std::max<std::size_t>(total, 1));
            std::size_t at = 0;
            for (std::size_t x = 0; x < counts_.size(); ++x) {
                pointers_[i][x] = values_[i].data() + at;
                at += counts_[x];
            }
        }
        part.readPixels(y, y);
        if (names_[1] == names_[0]) std::copy(values_[0].begin(), values_[0].end(), values_[1].begin());
    }
    [[nodiscard]] std::size_t count(std::size_t x) const { return counts_[x]; }
    [[nodiscard]] const float* values(std::size_t plane, std::size_t x) const { return pointers_[plane][x]; }

  private:
    std::vector<std::string> names_;
    std::vector<unsigned> counts_;
    std::vector<std::vector<float*>> pointers_;
    std::vector<std::vector<float>> values_;
};

void check_pixel(const DeepRow& row, const Comparison& comparison, int x, int y, std::size_t pixel,
                 DeepCheck& verdict) {
    constexpr double unit = 0x1p-23;
    const auto column = static_cast<std::size_t>(x);
    const std::size_t n = row.count(column);
    const float *z = row.values(0, column), *z_back = row.values(1, column), *a = row.values(2, column);
    verdict.samples += n;
    verdict.most_samples = std::max(verdict.most_samples, n);
    double transmittance = 1;
    for (std::size_t k = 0; k < n; ++k) {
        transmittance *= 1 - static_cast<double>(a[k]);
        if (!(z[k] >= 0) || z_back[k] < z[k] || (k > 0 && z[k] < z[k - 1])) verdict.sorted = false;
    }
    bool exceeds = false, clamped = false;
    const double count = static_cast<double>(n);
    if (comparison.alpha != nullptr) {
        const double error = std::abs(1 - transmittance - static_cast<double>(comparison.alpha->values[pixel]));
        exceeds = !(error <= (count + 1) * unit);
        if (error > verdict.largest_alpha) {
            verdict.largest_alpha = error;
            verdict.alpha_x = x;
            verdict.alpha_y = y;
        }
    }
    for (std::size_t p = 0; p < comparison.pairs.size(); ++p) {
        const Pair& pair = comparison.pairs[p];
        const float* c = row.values(3 + p, column);
        double sum = 0, scale = 0, front = 1;
        bool sum_is_clamped = false;
        for (std::size_t k = 0; k < n; ++k) {
            sum += front * static_cast<double>(c[k]);
            scale += std::abs(static_cast<double>(c[k]));
            front *= 1 - static_cast<double>(a[k]);
            sum_is_clamped = sum_is_clamped || is_clamped(c[k], pair.type);
        }
        const auto shallow = static_cast<double>(pair.shallow->values[pixel]);
        const bool shallow_is_clamped = is_clamped(pair.shallow->values[pixel], pair.shallow->stored);
        clamped = clamped || sum_is_clamped || shallow_is_clamped;
        const double error = error_of_clamped(sum, shallow, sum_is_clamped, shallow_is_clamped),
                     whole = scale + std::abs(shallow);
        exceeds =
            exceeds || !(error <= (count * unit + precision_of(pair.type).unit) * scale +
                                      precision_of(pair.shallow->stored).unit * whole + 0x1p-24);  // halves below 2^-14
        const double relative = whole > 0 ? error / whole : 0;
        if (relative > verdict.largest_color) {
            verdict.largest_color = relative;
            verdict.color_x = x;
            verdict.color_y = y;
        }
    }
    verdict.exceeding += exceeds ? 1 : 0;
    verdict.clamped += clamped ? 1 : 0;
}

}  // namespace

Result<DeepCheck> check_deep(const std::string& path, const ExrImage& image) {
    if (Status sound = check_exr_file(path); !sound) return sound.error();
    try {
        Imf::MultiPartInputFile file(path.c_str());
        int index = -1;
        for (int i = 0; i < file.parts() && index < 0; ++i)
            if (file.header(i).hasType() && file.header(i).type() == Imf::DEEPSCANLINE) index = i;
        if (index < 0)
            return error_at({path, 0, 0}, "this file has no deep scanline part; expected a deep OpenEXR file");
        const Imf::Header& header = file.header(index);
        const Imath::Box2i window = header.dataWindow();
        if (window.max.x - window.min.x + 1 != image.width || window.max.y - window.min.y + 1 != image.height)
            return error_at({path, 0, 0}, "the deep image is " + std::to_string(window.max.x - window.min.x + 1) + "x" +
                                              std::to_string(window.max.y - window.min.y + 1) + ", the shallow one " +
                                              std::to_string(image.width) + "x" + std::to_string(image.height) +
                                              "; expected equal sizes");
        const Comparison comparison = match(header.channels(), image);
        for (const char* needed : {"Z", "A"})
            if (header.channels().findChannel(needed) == nullptr)
                return error_at({path, 0, 0},
                                std::string("the deep image has no channel ") + needed + "; expected Z and A");
        if (comparison.pairs.empty())
            return error_at({path, 0, 0},
                            "no channel of the deep image is in the shallow image; expected R G B, or layers "
                            "with the same names");
        std::vector<std::string> names{"Z", header.channels().findChannel("ZBack") != nullptr ? "ZBack" : "Z", "A"};
        for (const Pair& pair : comparison.pairs) names.push_back(pair.channel);
        Imf::DeepScanLineInputPart part(file, index);
        DeepCheck verdict;
        verdict.layers = comparison.layers;
        DeepRow row(image.width, names);
        for (int y = 0; y < image.height; ++y) {
            row.read(part, window.min.y + y, window.min.x);
            for (int x = 0; x < image.width; ++x)
                check_pixel(
                    row, comparison, x, y,
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x),
                    verdict);
        }
        verdict.holds = verdict.exceeding == 0 && verdict.sorted;
        return verdict;
    } catch (const std::exception& exception) {
        return error_at({path, 0, 0}, std::string("cannot read the deep image: ") + exception.what());
    }
}

}  // namespace raylex::display
