#include "transport/color/film_sensor.h"

#include <algorithm>
#include <cmath>

#include "display/services/parameters.h"
#include "transport/color/spectral_data.h"

namespace raylex::transport {
namespace {

constexpr Matrix3 unit{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
// Cone responses from XYZ (Lam 1985, "Metamerism and colour constancy", University of Bradford; CIE 159:2004).
constexpr Matrix3 bradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

const std::vector<std::string>& camera_sensors() {
    static const std::vector<std::string> names{
        "canon_eos_100d",     "canon_eos_1dx_mkii", "canon_eos_200d",    "canon_eos_200d_mkii", "canon_eos_5d",
        "canon_eos_5d_mkii",  "canon_eos_5d_mkiii", "canon_eos_5d_mkiv", "canon_eos_5ds",       "canon_eos_m",
        "hasselblad_l1d_20c", "nikon_d810",         "nikon_d850",        "sony_ilce_6400",      "sony_ilce_7m3",
        "sony_ilce_7rm3",     "sony_ilce_9"};
    return names;
}

Triple white_of(double kelvin) {
    Triple xyz = integrate_xyz(kelvin < 4000 ? blackbody_spectrum(kelvin) : daylight_spectrum(kelvin));
    const double y = xyz[1];
    for (double& c : xyz) c /= y;
    return xyz;
}

/// In RGB of `space`: light as white as daylight of `kelvin` becomes white.
Matrix3 balance(double kelvin, ColorSpace space) {
    const Triple from = multiply(bradford, white_of(kelvin)), to = multiply(bradford, white_xyz(space));
    Matrix3 scale = unit;
    for (std::size_t i = 0; i < 3; ++i) scale[i][i] = to[i] / from[i];
    const Matrix3 in_xyz = multiply(inverse(bradford), multiply(scale, bradford));
    return multiply(rgb_from_xyz(space), multiply(in_xyz, xyz_from_rgb(space)));
}

/// A shutter that opens for an instant lets in nothing, at which pbrt-v4 stops; here it means a moment in time.
Result<double> exposure_time(const SceneEntity& film, const SceneEntity& camera, std::vector<Error>& warnings) {
    auto open = camera.parameters.real_or("shutteropen", 0), close = camera.parameters.real_or("shutterclose", 1);
    if (!open) return open.error();
    if (!close) return close.error();
    double span = std::abs(*close - *open);
    if (span == 0 && film.parameters.find("exposuretime") == nullptr) {
        span = 1;
        warnings.push_back(
            error_at(camera.location, "the shutter opens for an instant; the film is exposed as if for a second"));
    }
    auto time = film.parameters.real_or("exposuretime", span);
    if (time && !(*time > 0))
        return error_at(film.location, "'exposuretime' is " + std::to_string(*time) + "; expected seconds above 0");
    return time;
}

}  // namespace

Result<Matrix3> read_sensor(const SceneEntity& film, const SceneEntity& camera, ColorSpace space,
                            std::vector<Error>& warnings) {
    auto iso = film.parameters.real_or("iso", 100), kelvin = film.parameters.real_or("whitebalance", 0);
    const auto time = exposure_time(film, camera, warnings);
    auto sensor = film.parameters.string_or("sensor", "cie1931");
    if (!iso) return iso.error();
    if (!kelvin) return kelvin.error();
    if (!time) return time.error();
    if (!sensor) return sensor.error();
    if (!(*iso > 0)) return error_at(film.location, "'iso' is " + std::to_string(*iso) + "; expected a number above 0");
    if (*sensor != "cie1931") {
        const std::vector<std::string>& known = camera_sensors();
        if (std::find(known.begin(), known.end(), *sensor) == known.end()) {
            const std::string near = nearest_name(*sensor, known);
            return error_at(film.parameters.find("sensor")->location,
                            "no sensor is called '" + *sensor + "'; expected cie1931 or a camera's, such as nikon_d850",
                            near.empty() ? "" : "did you mean '" + near + "'?");
        }
        if (*kelvin == 0) *kelvin = 6500;
        warnings.push_back(error_at(film.parameters.find("sensor")->location,
                                    "sensor '" + *sensor +
                                        "' is taken as cie1931 with its exposure and white balance: greys are its "
                                        "own, saturated colours differ by its spectral response"));
    }
    if (*kelvin != 0 && !(*kelvin >= 1000 && *kelvin <= 25000))
        return error_at(film.location, "'whitebalance' is " + std::to_string(*kelvin) +
                                           "; expected a temperature between 1000 and 25000 K, or 0 for none");
    if (*kelvin != 0)
        warnings.push_back(error_at(film.location,
                                    "white balance is applied to the colours of lights: exact for greys, while "
                                    "coloured surfaces differ a little from balancing the image"));
    Matrix3 matrix = *kelvin != 0 ? balance(*kelvin, space) : unit;
    for (auto& row : matrix)
        for (double& m : row) m *= *time * *iso / 100;
    return matrix;
}

}  // namespace raylex::transport
