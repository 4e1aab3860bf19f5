// Mixes the lights of a rendered image: scales layers of light groups and recomputes the beauty.
#pragma once

#include <string>
#include <vector>

#include "experiments/mix/mix.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct MixedImage {
    std::vector<std::string> scaled;    ///< the layers with a factor
    std::vector<std::string> kept;      ///< the other layers of the same split, with the light that they had
    std::vector<std::string> left_out;  ///< layers and partitions that cannot follow the factors
    bool is_proved = false;             ///< the header declares the partition that has the scaled layers
    bool is_whole = false;              ///< the layers of a split are known, so that `unassigned` is meaningful
    double unassigned = 0;              ///< beauty minus the layers, as a fraction of the beauty; kept as it is
};

/// The warnings about a mix: no declared partition, what is left out, light without a layer.
std::vector<std::string> mix_notes(const MixedImage& mixed);

/// Writes the image `from` to `to` with the factors of `mix.lights`, which name layers or light groups.
///
/// The scaled layers must belong to one split of the beauty: a partition that the header declares, or the layers of one
/// split of another renderer (experiments/verify/presets.h). With the factors f, the beauty becomes
/// sum f x layer + (beauty - sum layer), per pixel and component, where the second term is kept only if it exceeds
/// rounding. A partition of a scaled layer follows it. `NAME_even`, `NAME_odd` and `NAME_error` follow;
/// `NAME_mse` and `NAME_variance` follow with the squared factor. Statistics of the beauty are left out (its variance
/// needs the covariance of the layers), as are all other layers of light. If all factors are 1, no pixel changes and no
/// layer is left out.
///
/// Errors: no factors, colours of objects, an unknown name, a name that occurs twice, layers of different splits, a
/// layer that a split multiplies by another one, a path atlas, `to` is `from`.
Result<MixedImage> mix_image(const std::string& from, const std::string& to, const Mix& mix,
                             const std::string& command);

}  // namespace raylex::experiments
