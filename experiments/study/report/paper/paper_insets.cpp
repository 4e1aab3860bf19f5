#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "display/output/atomic_file.h"
#include "display/output/color/color_manager.h"
#include "experiments/program/console.h"
#include "experiments/report/html.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/page/pictures.h"
#include "experiments/study/report/paper/paper.h"

namespace raylex::experiments {
namespace {

constexpr std::size_t most_insets = 4, most_columns = 6;
constexpr int inset_side = 256;  // minimum pixels of an inset's longer side, without the frame

struct FrameColor {
    const char* name;
    std::array<unsigned char, 3> rgb;
};
constexpr std::array<FrameColor, most_insets> frame_colors{{{"#e4572e", {0xe4, 0x57, 0x2e}},
                                                            {"#2e86de", {0x2e, 0x86, 0xde}},
                                                            {"#2fa84f", {0x2f, 0xa8, 0x4f}},
                                                            {"#b455c8", {0xb4, 0x55, 0xc8}}}};

/// An 8-bit RGB image, rows from the top.
struct Bitmap {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;

    Bitmap(int w, int h) : width(w), height(h), rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3) {}
    unsigned char* at(int x, int y) {
        return &rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 3];
    }
};

/// Converts a pixel by the sRGB curve, as the page does. Non-finite values become magenta.
void show(const double* light, unsigned char* pixel) {
    constexpr std::array<unsigned char, 3> broken{255, 0, 255};
    if (!std::isfinite(light[0] + light[1] + light[2])) {
        std::copy(broken.begin(), broken.end(), pixel);
        return;
    }
    for (std::size_t c = 0; c < 3; ++c) {
        const double v = std::clamp(light[c], 0.0, 1.0);
        const double shown = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
        pixel[c] = static_cast<unsigned char>(std::lround(shown * 255));
    }
}

/// Returns a part of an image with `scale` x `scale` pixels per pixel, and room for a frame around it.
Bitmap magnified(const PixelArray& image, const InsetBox& box, int scale, int frame) {
    Bitmap bitmap(box.width * scale + 2 * frame, box.height * scale + 2 * frame);
    for (int y = 0; y < box.height * scale; ++y)
        for (int x = 0; x < box.width * scale; ++x) {
            const auto u = static_cast<std::size_t>(box.x + x / scale), v = static_cast<std::size_t>(box.y + y / scale);
            show(&image.values[(v * image.width + u) * 3], bitmap.at(x + frame, y + frame));
        }
    return bitmap;
}

/// Draws the outline of a rectangle, `thick` pixels inwards.
void draw_frame(Bitmap& bitmap, const InsetBox& box, int thick, const FrameColor& color) {
    for (int y = std::max(0, box.y); y < std::min(bitmap.height, box.y + box.height); ++y)
        for (int x = std::max(0, box.x); x < std::min(bitmap.width, box.x + box.width); ++x)
            if (x < box.x + thick || y < box.y + thick || x >= box.x + box.width - thick ||
                y >= box.y + box.height - thick)
                std::copy(color.rgb.begin(), color.rgb.end(), bitmap.at(x, y));
}

/// Summed-area table of squared relative differences, so that the sum over a rectangle takes four look-ups.
class DifferenceSums {
  public:
    DifferenceSums(int width, int height)
        : width_(width),
          sums_(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height + 1)),
          height_(height) {}

    void add(const PixelArray& image, const PixelArray& reference) {
        double mean = 0;
        for (const double value : reference.values)
            mean += std::abs(value) / static_cast<double>(reference.values.size());
        for (int y = 0; y < height_; ++y) {
            double row = 0;
            for (int x = 0; x < width_; ++x) {
                for (std::size_t c = 0; c < 3; ++c) {
                    const std::size_t i =
                        (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)) *
                            3 +
                        c;
                    const double b = reference.values[i], d = image.values[i] - b;
                    const double square = d * d / (b * b + 0.01 * mean * mean + 1e-30);
                    // Limits a pixel to 1, so that a single firefly does not determine the rectangle.
                    if (std::isfinite(square)) row += std::min(square, 1.0);
                }
                sums_[index(x + 1, y + 1)] += row;
            }
        }
    }
    /// Call it once after all images were added.
    void finish() {
        for (int y = 1; y <= height_; ++y)
            for (int x = 1; x <= width_; ++x) sums_[index(x, y)] += sums_[index(x, y - 1)];
    }
    [[nodiscard]] double of(const InsetBox& box) const {
        return sums_[index(box.x + box.width, box.y + box.height)] - sums_[index(box.x, box.y + box.height)] -
               sums_[index(box.x + box.width, box.y)] + sums_[index(box.x, box.y)];
    }

  private:
    [[nodiscard]] std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1) + static_cast<std::size_t>(x);
    }
    int width_;
    std::vector<double> sums_;
    int height_;
};

bool overlap(const InsetBox& a, const InsetBox& b) {
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

std::optional<PixelArray> beauty_of(const SceneInfo& scene, const std::string& directory) {
    Result<PixelArray> image = read_mean(directory, scene.channels.front().name);
    if (!image || image->components != 3 || image->width != static_cast<std::size_t>(scene.width) ||
        image->height != static_cast<std::size_t>(scene.height))
        return std::nullopt;
    return std::move(*image);
}

struct Shown {
    PictureSource source;
    PixelArray image;
};

std::vector<Shown> images_of(const Study& study, std::size_t scene) {
    std::vector<Shown> shown;
    for (const PictureSource& source : picture_sources(study))
        if (source.scene == scene)
            if (auto image = beauty_of(study.experiment->scenes[scene], source.directory))
                shown.push_back({source, std::move(*image)});
    return shown;
}

std::vector<InsetBox> boxes_of(const Study& study, const SceneInfo& scene, const std::vector<Shown>& images) {
    std::vector<InsetBox> boxes;
    for (const Region& region : study.experiment->regions)
        if ((region.scene.empty() || region.scene == scene.name) && region.crop[2] > region.crop[0] &&
            region.crop[3] > region.crop[1] && region.crop[2] <= scene.width && region.crop[3] <= scene.height &&
            boxes.size() < most_insets)
            boxes.push_back(
                {region.crop[0], region.crop[1], region.crop[2] - region.crop[0], region.crop[3] - region.crop[1]});
    const bool reference = !images.empty() && images.back().source.variant.empty();
    if (!boxes.empty() || !reference || images.size() < 2) return boxes;
    const int side = std::max(1, std::min(scene.width, scene.height) / 5), step = std::max(1, side / 4);
    DifferenceSums sums(scene.width, scene.height);
    for (std::size_t i = 0; i + 1 < images.size(); ++i) sums.add(images[i].image, images.back().image);
    sums.finish();
    for (int wanted = 0; wanted < 2; ++wanted) {
        std::optional<InsetBox> best;
        for (int y = 0; y + side <= scene.height; y += step)
            for (int x = 0; x + side <= scene.width; x += step) {
                const InsetBox box{x, y, side, side};
                const bool free = std::none_of(boxes.begin(), boxes.end(),
                                               [&](const InsetBox& other) { return overlap(box, other); });
                if (free && (!best || sums.of(box) > sums.of(*best))) best = box;
            }
        if (best) boxes.push_back(*best);
    }
    return boxes;
}

/// Layout of the SVG: the reference on the left, then a column of insets per image.
class InsetFigure {
  public:
    InsetFigure(const SceneInfo& scene, const std::vector<InsetBox>& boxes) : boxes_(boxes) {
        for (const InsetBox& box : boxes) heights_.push_back(column * box.height / box.width);
        for (const double each : heights_) total_ += each + gap;
        total_ = std::max(total_ - gap, 120.0);
        left_ = total_ * scene.width / scene.height;
    }
    void set_whole(const std::string& uri, const std::string& name) {
        body_ += picture(0, 0, left_, total_, uri) + label(left_ / 2, total_ + 16, name, 600);
    }
    void add_column(const std::vector<std::string>& uris, const std::string& name, const std::string& error) {
        const double x = left_ + gap + count_++ * (column + gap);
        double y = 0;
        for (std::size_t i = 0; i < uris.size(); y += heights_[i] + gap, ++i)
            body_ += picture(x, y, column, heights_[i], uris[i]);
        body_ += label(x + column / 2, total_ + 16, name, 600) + label(x + column / 2, total_ + 31, error, 400);
    }
    [[nodiscard]] std::string svg() const {
        const double width = left_ + count_ * (column + gap);
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + plain_number(width, 6) + " " +
               plain_number(total_ + 38, 6) +
               "\" font-family=\"system-ui, DejaVu Sans, sans-serif\" font-size=\"11\">\n" + body_ + "</svg>\n";
    }

  private:
    static constexpr double column = 150, gap = 6;

    static std::string picture(double x, double y, double width, double height, const std::string& uri) {
        return "<image x=\"" + plain_number(x, 6) + "\" y=\"" + plain_number(y, 6) + "\" width=\"" +
               plain_number(width, 6) + "\" height=\"" + plain_number(height, 6) +
               "\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"" + uri + "\"/>\n";
    }
    /// Compresses text that is longer than its column, instead of cutting it off.
    static std::string label(double x, double y, const std::string& text, int weight) {
        const bool tight = static_cast<double>(text.size()) * 6.6 > column;
        return "<text x=\"" + plain_number(x, 6) + "\" y=\"" + plain_number(y, 6) +
               "\" text-anchor=\"middle\" font-weight=\"" + std::to_string(weight) + "\"" +
               (tight ? " lengthAdjust=\"spacingAndGlyphs\" textLength=\"" + plain_number(column) + "\"" : "") + ">" +
               escape_html(text) + "</text>\n";
    }

    const std::vector<InsetBox>& boxes_;
    std::vector<double> heights_;
    double total_ = 0, left_ = 0;
    int count_ = 0;
    std::string body_;
};

/// Writes a picture and returns it for embedding.
Result<std::string> write_picture(const std::string& path, const Bitmap& bitmap) {
    auto png = display::encode_png(bitmap.width, bitmap.height, bitmap.rgb);
    if (!png) return png.error();
    Status written = display::write_png(path, bitmap.width, bitmap.height, bitmap.rgb);
    if (!written) return written.error();
    return data_uri(*png);
}

std::string error_text(const Study& study, const SceneInfo& scene, const std::string& variant) {
    const Curve* curve = study.curve(scene.name, variant, scene.channels.front().name);
    if (curve == nullptr || curve->points.empty()) return {};
    const double error = curve->points.back().relative.value;
    return std::isfinite(error) ? "error " + percent_text(error) : std::string();
}

Result<std::size_t> write_scene(const Study& study, const SceneInfo& scene, const std::vector<Shown>& images,
                                const std::string& folder) {
    const std::vector<InsetBox> boxes = boxes_of(study, scene, images);
    InsetFigure figure(scene, boxes);
    std::size_t files = 0, columns = 0;
    for (const Shown& each : images) {
        const bool reference = each.source.variant.empty();
        const std::string base =
            folder + "/" + file_part(scene.name) + "." + file_part(reference ? "reference" : each.source.variant);
        Bitmap whole = magnified(each.image, {0, 0, scene.width, scene.height}, 1, 0);
        for (std::size_t i = 0; i < boxes.size(); ++i)
            draw_frame(whole, boxes[i], std::max(1, scene.width / 256), frame_colors[i]);
        auto uri = write_picture(base + ".png", whole);
        if (!uri) return uri.error();
        ++files;
        if (&each == &images.back()) figure.set_whole(*uri, each.source.name);
        std::vector<std::string> uris;
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            const int scale = std::max(1, inset_side / std::max(boxes[i].width, boxes[i].height)), frame = 4;
            Bitmap inset = magnified(each.image, boxes[i], scale, frame);
            draw_frame(inset, {0, 0, inset.width, inset.height}, frame, frame_colors[i]);
            auto small = write_picture(base + ".inset" + std::to_string(i + 1) + ".png", inset);
            if (!small) return small.error();
            uris.push_back(std::move(*small));
            ++files;
        }
        if (!uris.empty() && (reference || columns++ < most_columns))
            figure.add_column(uris, each.source.name, reference ? "" : error_text(study, scene, each.source.variant));
    }
    Status written = display::write_text_file(folder + "/" + file_part(scene.name) + ".svg", figure.svg());
    if (!written) return written.error();
    return files + 1;
}

}  // namespace

std::vector<InsetBox> inset_boxes(const Study& study, std::size_t scene) {
    return boxes_of(study, study.experiment->scenes[scene], images_of(study, scene));
}

Result<std::size_t> write_insets(const Study& study, const std::string& folder) {
    std::size_t files = 0;
    for (std::size_t scene = 0; scene < study.experiment->scenes.size(); ++scene) {
        const std::vector<Shown> images = images_of(study, scene);
        if (images.empty()) continue;
        auto written = write_scene(study, study.experiment->scenes[scene], images, folder);
        if (!written) return written.error();
        files += *written;
    }
    return files;
}

}  // namespace raylex::experiments
