// The window that the film spans, for cameras that project onto a plane.
#pragma once

#include <array>

#include "transport/cameras/camera.h"

namespace raylex::transport {

/// Returns x min, x max, y min, y max: "screenwindow" if given, else the window of "frameaspectratio" or of the image's
/// aspect ratio, with the shorter axis from -1 to 1.
Result<std::array<double, 4>> read_screen_window(const SceneEntity& entity, const CameraPlacement& placement);

/// The parameters "lensradius" and "focaldistance".
struct ThinLens {
    double radius = 0, focal_distance = 1e6;
};
Result<ThinLens> read_thin_lens(const SceneEntity& entity);

/// Scales and moves x and y so that a window of camera space becomes [-1, 1]^2.
struct WindowScale {
    double sx, sy, ox, oy;
    explicit WindowScale(const std::array<double, 4>& window, double unit = 1)
        : sx(2 / ((window[1] - window[0]) * unit)),
          sy(2 / ((window[3] - window[2]) * unit)),
          ox(-(window[1] + window[0]) / (window[1] - window[0])),
          oy(-(window[3] + window[2]) / (window[3] - window[2])) {}
};

}  // namespace raylex::transport
