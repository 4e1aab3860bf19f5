#include "transport/scene/film_sensor.h"

#include <algorithm>
#include <cmath>

#include "display/services/parameters.h"
#include "display/services/short_number.h"
#include "transport/color/camera_sensors.h"
#include "transport/color/spectral_data.h"

namespace raylex::transport {
namespace {

constexpr Matrix3 unit{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
// Cone responses from XYZ (Lam 1985, "Metamerism and colour constancy", University of Bradford; CIE 159:2004).
constexpr Matrix3 bradford{{{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

Triple white_of(double kelvin) {
    Triple xyz = integrate_xyz(kelvin < 4000 ? blackbody_spectrum(kelvin) : daylight_spectrum(kelvin));
    const double y = xyz[1];
    for (double& c : xyz) c /= y;
    return xyz;
}

/// The matrix in XYZ that takes the white of daylight of `kelvin` to the white of `space`.
Matrix3 balance(double kelvin, ColorSpace space) {
    const Triple from = multiply(bradford, white_of(kelvin)), to = multiply(bradford, white_xyz(space));
    Matrix3 scale = unit;
    for (std::size_t i = 0; i < 3; ++i) scale[i][i] = to[i] / from[i];
    return multiply(inverse(bradford), multiply(scale, bradford));
}

Matrix3 in_rgb(const Matrix3& in_xyz, ColorSpace space) {
    return multiply(rgb_from_xyz(space), multiply(in_xyz, xyz_from_rgb(space)));
}

/// The exposure time in seconds. A shutter that opens for an instant would record nothing, and pbrt-v4 stops with an
/// error; here it means a moment in time.
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
        return error_at(film.location, "'exposuretime' is " + short_number(*time, 6) + "; expected seconds above 0");
    return time;
}

}  // namespace

Result<FilmSensor> read_sensor(const SceneEntity& film, const SceneEntity& camera, ColorSpace space,
                               std::vector<Error>& warnings) {
    auto iso = film.parameters.real_or("iso", 100), kelvin = film.parameters.real_or("whitebalance", 0);
    const auto time = exposure_time(film, camera, warnings);
    auto sensor = film.parameters.string_or("sensor", "cie1931");
    if (!iso) return iso.error();
    if (!kelvin) return kelvin.error();
    if (!time) return time.error();
    if (!sensor) return sensor.error();
    if (!(*iso > 0))
        return error_at(film.location, "'iso' is " + short_number(*iso, 6) + "; expected a number above 0");
    const bool named = *sensor != "cie1931";
    const std::vector<std::string>& known = camera_sensors();
    if (named && std::find(known.begin(), known.end(), *sensor) == known.end()) {
        return error_at(
            film.parameters.find("sensor")->location,
            "there is no sensor '" + *sensor + "'; expected cie1931 or the name of a camera, such as nikon_d850",
            near_miss(*sensor, known));
    }
    if (named && *kelvin == 0) *kelvin = 6500;
    if (*kelvin != 0 && !(*kelvin >= 1000 && *kelvin <= 25000))
        return error_at(film.location, "'whitebalance' is " + short_number(*kelvin, 6) +
                                           "; expected a temperature between 1000 and 25000 K, or 0 for none");
    Matrix3 matrix = unit;
    if (named) {
        warnings.push_back(error_at(film.parameters.find("sensor")->location,
                                    "sensor '" + *sensor +
                                        "' is applied to the colours of lights: exact for white, within some 0.4 % for "
                                        "daylight and blackbodies, while coloured surfaces differ by some 3 %, "
                                        "since RGB does not contain their spectra",
                                    *kelvin < camera_sensor_coldest
                                        ? "below 2500 K the sensor's responses are those for a balance of 2500 K"
                                        : ""));
        matrix = in_rgb(multiply(*camera_sensor(*sensor, *kelvin, space), balance(*kelvin, ColorSpace::srgb)), space);
    } else if (*kelvin != 0) {
        warnings.push_back(error_at(film.location,
                                    "white balance is applied to the colours of lights: exact for greys, while "
                                    "coloured surfaces differ a little from balancing the image"));
        matrix = in_rgb(balance(*kelvin, space), space);
    }
    const double exposure = *time * *iso / 100;
    FilmSensor result{matrix, multiply(xyz_from_rgb(space), inverse(matrix))};
    for (auto& row : result.recorded)
        for (double& m : row) m *= exposure;
    if (named) result.measured[0] = result.measured[2] = result.measured[1];
    return result;
}

}  // namespace raylex::transport
