#include "transport/cameras/realistic.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "transport/math/sampling.h"

namespace raylex::transport {

Result<std::unique_ptr<Camera>> RealisticCamera::build(const SceneEntity& entity, const CameraPlacement& placement) {
    const ParameterSet& set = entity.parameters;
    auto file = set.string_or("lensfile", "");
    if (!file) return file.error();
    if (file->empty()) return error_at(entity.location, "a realistic camera without 'lensfile'; expected a lens file");
    auto diameter = set.real_or("aperturediameter", 1), distance = set.real_or("focusdistance", 10);
    if (!diameter) return diameter.error();
    if (!distance) return distance.error();
    if (!(*diameter > 0)) return error_at(entity.location, "'aperturediameter' must be positive, in millimetres");
    if (!(*distance > 0)) return error_at(entity.location, "'focusdistance' must be positive, in metres");
    auto shape = set.string_or("aperture", "");
    if (!shape) return shape.error();
    auto aperture = Aperture::named(*shape, entity.location);
    if (!aperture) return aperture.error();
    std::vector<Error> warnings;
    auto lens = LensSystem::read(*file, *diameter * 1e-3, std::move(*aperture), entity.location, warnings);
    if (!lens) return named_by(lens.error(), "'lensfile'", entity.location);
    if (Status s = lens->focus(*distance, entity.location); !s) return s.error();
    const double diagonal = placement.film_diagonal * 1e-3,
                 aspect = static_cast<double>(placement.height) / static_cast<double>(placement.width);
    const double film_x = diagonal / std::sqrt(1 + aspect * aspect);
    // The angle of a pixel, approximately, as seen from the last element.
    const double pixel = film_x / placement.width / lens->rear_z();
    std::unique_ptr<RealisticCamera> camera(
        new RealisticCamera(placement, {static_cast<Real>(pixel), static_cast<Real>(pixel)}, std::move(*lens)));
    camera->film_x_ = film_x;
    camera->film_y_ = film_x * aspect;
    camera->half_diagonal_ = diagonal / 2;
    camera->spread_ = static_cast<Real>(pixel);
    camera->warnings_ = std::move(warnings);
    camera->find_pupils();
    return std::unique_ptr<Camera>(std::move(camera));
}

RealisticCamera::RealisticCamera(const CameraPlacement& placement, const Vec2& pixel_size, LensSystem lens)
    : Camera(placement.camera_to_world, Matrix4{}, pixel_size, true),  // no matrix takes points to a screen
      placement_(placement.camera_to_world),
      lens_(std::move(lens)),
      width_(placement.width),
      height_(placement.height) {}

/// Finds, for each ring of the film, the part of the last element's plane from which rays leave at the front: traces a
/// grid of rays from the inner edge, the outer edge and the middle of the ring, and takes the box around those that
/// pass, enlarged by a cell.
void RealisticCamera::find_pupils() {
    constexpr int cells = 64;
    const double reach = 1.5 * lens_.rear_radius(), cell = 2 * reach / cells;
    for (int ring = 0; ring < pupil_count; ++ring) {
        Pupil pupil{reach, -reach, reach, -reach};
        for (int part = 0; part <= 2; ++part) {
            const double r = (ring + part / 2.0) / pupil_count * half_diagonal_;
            for (int y = 0; y <= cells; ++y)
                for (int x = 0; x <= cells; ++x) {
                    const double px = x * cell - reach, py = y * cell - reach;
                    const DVec3 from{r, 0, 0};
                    LensRay ray{from, normalize(DVec3{px, py, lens_.rear_z()} - from)};
                    if (!(lens_.trace(ray) > 0)) continue;
                    pupil = {std::min(pupil.x0, px), std::max(pupil.x1, px), std::min(pupil.y0, py),
                             std::max(pupil.y1, py)};
                }
        }
        if (pupil.x0 > pupil.x1) pupil = {-reach, reach, -reach, reach};  // no ray passed: use the whole plane
        else pupil = {pupil.x0 - cell, pupil.x1 + cell, pupil.y0 - cell, pupil.y1 + cell};
        pupils_[static_cast<std::size_t>(ring)] = pupil;
    }
}

Ray RealisticCamera::ray(const CameraSample& sample, Real& weight) const {
    // The image on the film is upside down: its top left corner is at +x, -y.
    const DVec3 film{(0.5 - double{sample.x} / width_) * film_x_, (double{sample.y} / height_ - 0.5) * film_y_, 0};
    const double r = length(film);
    const int ring = std::min(static_cast<int>(r / half_diagonal_ * pupil_count), pupil_count - 1);
    const Pupil& pupil = pupils_[static_cast<std::size_t>(ring)];
    const double x = pupil.x0 + (pupil.x1 - pupil.x0) * double{sample.lens.x},
                 y = pupil.y0 + (pupil.y1 - pupil.y0) * double{sample.lens.y};
    const double c = r > 0 ? film.x / r : 1, s = r > 0 ? film.y / r : 0;
    LensRay ray{film, normalize(DVec3{c * x - s * y, s * x + c * y, lens_.rear_z()} - film)};
    const double cosine = ray.direction.z, rear = lens_.rear_z();
    const double left = lens_.trace(ray);
    weight = static_cast<Real>(left * cosine * cosine * cosine * cosine * pupil.area() / (rear * rear));
    Ray result;
    result.origin = placement_.to_world.point(ray.origin).to_real();
    result.direction = normalize(placement_.to_world.vector(ray.direction)).to_real();
    result.cone.spread = spread_;
    if (!(left > 0)) result.t_max = 0;
    return result;
}

void RealisticCamera::generate(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    Real unused = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) rays[i] = ray(samples[i], unused);
}

void RealisticCamera::weigh(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const {
    for (std::size_t i = 0; i < samples.size(); ++i) rays[i] = ray(samples[i], weights[i]);
}

// The raster position that sees a point through a point of the lens has no closed form. Integrators that need it refuse
// the camera (Camera::weighs_rays).
bool RealisticCamera::connect_to(const Vec3&, const Vec2&, CameraConnection&) const {
    return false;
}
Real RealisticCamera::importance_of(const Vec3&, const Vec3&) const {
    return 0;
}

}  // namespace raylex::transport
