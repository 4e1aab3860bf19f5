// Denoises the layers of light of an OpenEXR image, from raylex or another renderer.
//
// Statistics. A layer NAME of light is denoised if the image has the variance of its pixels, NAME_mse, or two halves of
// its samples, NAME_even and NAME_odd, or if a second render with other random numbers is given. All layers of a
// declared partition need them. Everything else is unchanged: alpha, AOVs, mattes, ids.
//
// Features. The albedo and the normal guide the filter if the image has them: albedo, Nn, __Nworld, or the names that
// Cycles and others use; with NAME_mse, or halves, their noise counts too.
#pragma once

#include <string>
#include <vector>

#include "display/output/denoise/denoise.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

struct DenoiseOptions {
    int threads = 0;          ///< 0: all cores
    bool keep_noisy = false;  ///< keeps noisy layers as NAME_noisy, and their statistics
    std::string second;       ///< file of a second render of the same image; empty: none
};

struct DenoisedLayer {
    std::string name;
    LayerError error;
};

struct DenoisedImage {
    std::vector<DenoisedLayer> layers;
    std::vector<std::string> features;              ///< layers that guided the filter
    std::vector<ImageLayer> removed;                ///< statistics of noisy layers, without values
    std::vector<std::string> added;                 ///< new layers: NAME_error, NAME_noisy
    std::map<std::string, std::string> attributes;  ///< for the header: what was done
    bool has_overscan = false;                      ///< the file has pixels outside the image, which keep their noise
};

/// Denoises `image` in place. NAME_error is the standard error of a pixel after denoising, the root of the mean over
/// its three components. Errors, which name the file: no statistics, a layer of a partition without statistics, values
/// that are not finite, an image that is denoised already, a second image that does not match.
Result<DenoisedImage> denoise_image(ExrImage& image, const DenoiseOptions& options);

/// Denoises the file `from` and writes the result to `to`, which can be the same file. Deep parts are copied.
Result<DenoisedImage> denoise_exr(const std::string& from, const std::string& to, const DenoiseOptions& options);

}  // namespace raylex::display
