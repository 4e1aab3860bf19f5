#include "transport/cameras/lens_system.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "display/services/short_number.h"
#include "lpe/input/read_input.h"

namespace raylex::transport {
namespace {

constexpr double millimetre = 1e-3;
constexpr std::size_t most_elements = 1000;
// Beyond these limits rays are lost to rounding or overflow. Files give flat surfaces radii of 1e10 mm, and no glass
// has an index near 100.
constexpr double longest = 1e12, largest_index = 100;

Status read_row(const std::string& line, const std::string& path, int number, std::vector<double>& numbers) {
    std::istringstream words(line);
    std::string word;
    while (words >> word) {
        const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
        const char* end = word.data() + word.size();
        double value = 0;
        const auto [stop, status] = std::from_chars(begin, end, value);
        if (status != std::errc() || stop != end || !std::isfinite(value))
            return Error{"found '" + word + "'; expected a number", path, number, 0, line, {}};
        numbers.push_back(value);
    }
    return success();
}

Error bad_row(const std::string& what, const std::string& path, int number, const std::string& line) {
    return Error{what + "; expected radius of curvature, thickness, index of refraction and diameter, in millimetres",
                 path,
                 number,
                 0,
                 line,
                 {}};
}

/// Refracts unit `d`, which comes against unit `n` (dot(d, n) < 0), from index `eta_i` into `eta_t`. Returns false for
/// total internal reflection.
bool refract(const DVec3& d, const DVec3& n, double eta_i, double eta_t, DVec3& refracted) {
    const double ratio = eta_i / eta_t, cosine = -dot(d, n);
    const double sin2 = ratio * ratio * std::max(0.0, 1 - cosine * cosine);
    if (sin2 >= 1) return false;
    refracted = normalize(d * ratio + n * (ratio * cosine - std::sqrt(1 - sin2)));
    return true;
}

/// Paraxial ray matrix: height and angle behind elements as a function of those before them.
struct Abcd {
    double a = 1, b = 0, c = 0, d = 1;
    /// The matrix of `first` followed by this.
    [[nodiscard]] Abcd after(const Abcd& first) const {
        return {a * first.a + b * first.c, a * first.b + b * first.d, c * first.a + d * first.c,
                c * first.b + d * first.d};
    }
};

}  // namespace

Result<LensSystem> LensSystem::read(const std::string& path, double stop_diameter, Aperture aperture,
                                    const SourceLocation& named_at, std::vector<Error>& warnings) {
    const Result<std::string> content = read_input(path, NamedBy::file, "a lens file");
    if (!content) return content.error();
    LensSystem lens;
    lens.aperture_ = std::move(aperture);
    std::istringstream lines(*content);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        if (const auto comment = line.find('#'); comment != std::string::npos) line.resize(comment);
        std::vector<double> row;
        if (Status s = read_row(line, path, number, row); !s) return s.error();
        if (row.empty()) continue;
        if (row.size() != 4) return bad_row(std::to_string(row.size()) + " numbers in a row", path, number, line);
        if (!(row[3] > 0)) return bad_row("a diameter that is not positive", path, number, line);
        if (!(row[1] >= 0)) return bad_row("a negative thickness", path, number, line);
        if (!(row[2] == 0 || row[2] >= 1)) return bad_row("an index below 1", path, number, line);
        if (row[2] > largest_index) return bad_row("an index above 100", path, number, line);
        if (std::max({std::abs(row[0]), row[1], row[3]}) > longest)
            return bad_row("a length above 1e12 mm", path, number, line);
        if (lens.elements_.size() == most_elements)
            return bad_row("more than " + std::to_string(most_elements) + " elements", path, number, line);
        LensElement element{row[0] * millimetre, row[1] * millimetre, row[2] == 0 ? 1 : row[2],
                            row[3] / 2 * millimetre};
        if (row[0] == 0 && stop_diameter > 0) {
            if (stop_diameter / 2 > element.radius)
                warnings.push_back(error_at(named_at, "'aperturediameter' is " +
                                                          short_number(stop_diameter / millimetre, 6) +
                                                          " mm, more than the lens file's stop of " +
                                                          short_number(row[3], 6) + " mm, which it is taken for"));
            element.radius = std::min(element.radius, stop_diameter / 2);
        }
        lens.elements_.push_back(element);
    }
    if (lens.elements_.empty()) return Error{"no lens element in the file", path, 0, 0, {}, {}};
    return lens;
}

// The film is at distance t behind the last element, the object at S - t before the first; S is `distance` less the
// length of the elements. With the elements' matrix (A B; C D) from film to front, a point of the film is imaged where
//     (A + (S - t) C) t + B + (S - t) D = 0.
Status LensSystem::focus(double distance, const SourceLocation& where) {
    Abcd system;
    double length = 0;
    for (std::size_t i = elements_.size(); i-- > 0;) {
        const LensElement& e = elements_[i];
        if (i + 1 < elements_.size()) {
            system = Abcd{1, e.thickness, 0, 1}.after(system);
            length += e.thickness;
        }
        const double before = i > 0 ? elements_[i - 1].eta : 1;
        // Towards the front, the centre of a positive radius lies behind.
        const double power = e.curvature != 0 ? (before - e.eta) / (e.curvature * before) : 0;
        system = Abcd{1, 0, power, e.eta / before}.after(system);
    }
    const double s = distance - length;
    const double a = -system.c, b = system.a + s * system.c - system.d, c = system.b + s * system.d;
    const double discriminant = b * b - 4 * a * c;
    double t = -1;
    if (a != 0 && discriminant >= 0) {
        const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
        const double first = q / a, second = q != 0 ? c / q : -1;
        t = std::min(first, second) > 0 ? std::min(first, second) : std::max(first, second);
    }
    if (!(t > 0) || !(s - t > 0))
        return error_at(where, "this lens cannot be focused at 'focusdistance' " + short_number(distance, 6) +
                                   " m; expected a distance farther from the film");
    elements_.back().thickness = t;
    return success();
}

double LensSystem::trace(LensRay& ray) const {
    double z = 0, left = 1;
    for (std::size_t i = elements_.size(); i-- > 0;) {
        const LensElement& e = elements_[i];
        z += e.thickness;
        const bool stop = e.curvature == 0;
        double t = 0;
        DVec3 normal{0, 0, -1};
        if (stop) {
            if (!(ray.direction.z > 0)) return 0;
            t = (z - ray.origin.z) / ray.direction.z;
        } else {
            // A centre on the film's side lies behind the vertex.
            const DVec3 to_center = DVec3{0, 0, z - e.curvature} - ray.origin;
            const double along = dot(to_center, ray.direction),
                         inside = e.curvature * e.curvature - (dot(to_center, to_center) - along * along);
            if (inside < 0) return 0;
            const double half = std::sqrt(inside);
            // The element is one of the sphere's two sides: the farther one for a convex front.
            t = e.curvature > 0 ? along + half : along - half;
        }
        if (t < 0) return 0;
        const DVec3 hit = ray.origin + ray.direction * t;
        if (stop) {
            left *= aperture_.transmittance(hit.x / e.radius, hit.y / e.radius);
            if (!(left > 0)) return 0;
        } else if (hit.x * hit.x + hit.y * hit.y > e.radius * e.radius) {
            return 0;
        }
        ray.origin = hit;
        if (stop) continue;
        normal = normalize(hit - DVec3{0, 0, z - e.curvature});
        if (dot(normal, ray.direction) > 0) normal = normal * -1;
        const double before = i > 0 ? elements_[i - 1].eta : 1;
        if (!refract(ray.direction, normal, e.eta, before, ray.direction)) return 0;
    }
    return left;
}

}  // namespace raylex::transport
