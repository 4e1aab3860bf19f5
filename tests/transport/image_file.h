// Image files that tests write for scenes to read.
#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "transport/math/vec.h"

/// A PFM file of RGB, which is removed at the end. `pixels` is row-major from the top.
class ImageFile {
  public:
    ImageFile(int width, int height, const std::vector<raylex::transport::Rgb>& pixels)
        : path_((std::filesystem::temp_directory_path() /
                 ("raylex_image_" + std::to_string(std::random_device{}()) + ".pfm"))
                    .string()) {
        std::ofstream file(path_, std::ios::binary);
        file << "PF\n" << width << ' ' << height << "\n-1.0\n";
        for (int y = height - 1; y >= 0; --y)
            for (int x = 0; x < width; ++x) {
                const auto& c = pixels[static_cast<std::size_t>(y * width + x)];
                const float rgb[3] = {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)};
                file.write(reinterpret_cast<const char*>(rgb), sizeof(rgb));
            }
    }
    ~ImageFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    ImageFile(const ImageFile&) = delete;
    ImageFile& operator=(const ImageFile&) = delete;
    [[nodiscard]] const std::string& path() const { return path_; }
    /// The file as a parameter of a scene file.
    [[nodiscard]] std::string parameter() const { return " \"string filename\" \"" + path_ + "\" "; }

  private:
    std::string path_;
};
