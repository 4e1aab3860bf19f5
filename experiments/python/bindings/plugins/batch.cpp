#include "experiments/python/bindings/plugins/batch.h"

#include <algorithm>
#include <array>

#include "transport/math/sampling.h"
#include "transport/paths/walk.h"

namespace raylex::python {

using transport::first_free_dimension;
using transport::Hit;
using transport::Ray;
using transport::Vec3;

namespace {

/// Number of dimensions for Python. The dimensions after them are keys for closures.
constexpr std::uint32_t most_dimensions = 1U << 20;

std::uint32_t dimension_of(std::uint32_t dimension) {
    if (dimension >= most_dimensions)
        fail("dimension " + std::to_string(dimension) + " is too large; expected 0 to " +
             std::to_string(most_dimensions - 1));
    return first_free_dimension + dimension;
}

Vec3 vec_of(const transport::Rgb& rgb) {
    return {rgb.r, rgb.g, rgb.b};
}

}  // namespace

Batch::Batch(const transport::CameraBatch& camera, const transport::IntegratorContext& context,
             transport::IntegratorThread& thread, transport::ThreadServices& services)
    : CallScope("this batch is no longer valid; it can be used only within integrate()"),
      camera_(camera),
      context_(context),
      thread_(thread),
      services_(services) {
    for (std::size_t row = 0; row < camera.rays.size(); ++row)
        paths_.push_back(services.lpe.begin(static_cast<int>(row)));
}

void Batch::check_own(const Points& points) const {
    check();
    if (points.batch.get() != this) fail("these points belong to another batch; expected points from this batch");
}

std::vector<std::uint32_t> Batch::rows_of(const py::object& rows) const {
    std::vector<std::uint32_t> result;
    if (rows.is_none()) {
        for (std::size_t i = 0; i < count(); ++i) result.push_back(static_cast<std::uint32_t>(i));
        return result;
    }
    const Array<std::int64_t> array = array_of<std::int64_t>(rows, "rows");
    check_shape(array, static_cast<std::size_t>(array.size()), 0, "rows");
    for (py::ssize_t i = 0; i < array.size(); ++i) {
        const std::int64_t row = array.data()[i];
        if (row < 0 || row >= static_cast<std::int64_t>(count()))
            fail("rows has " + std::to_string(row) + "; expected 0 to " + std::to_string(count() - 1));
        result.push_back(static_cast<std::uint32_t>(row));
    }
    return result;
}

py::array_t<float> Batch::numbers(std::uint32_t dimension, const py::object& rows) const {
    const std::vector<std::uint32_t> of = rows_of(rows);
    const std::uint32_t at = dimension_of(dimension);
    return column_of<float>(of.size(), [&](std::size_t i) { return camera().samplers[of[i]].get_1d(at); });
}

py::array_t<float> Batch::numbers_2d(std::uint32_t dimension, const py::object& rows) const {
    const std::vector<std::uint32_t> of = rows_of(rows);
    const std::uint32_t at = dimension_of(dimension);
    std::vector<float> numbers;
    for (const std::uint32_t row : of) {
        const transport::Vec2 u = camera().samplers[row].get_2d(at);
        numbers.insert(numbers.end(), {transport::to_float(u.x), transport::to_float(u.y)});
    }
    return owning_array(std::move(numbers), {static_cast<py::ssize_t>(of.size()), 2});
}

std::shared_ptr<Points> Batch::trace() {
    const transport::CameraBatch& batch = camera();
    return trace({batch.rays.begin(), batch.rays.end()}, rows_of(py::none()), true);
}

std::shared_ptr<Points> Batch::trace_rays(const py::object& origins, const py::object& directions,
                                          const py::object& rows) {
    const std::vector<std::uint32_t> of = rows_of(rows);
    const Triples from(origins, of.size(), "origins"), towards(directions, of.size(), "directions");
    std::vector<Ray> rays(of.size());
    for (std::size_t i = 0; i < of.size(); ++i) {
        rays[i] = camera().rays[of[i]];
        rays[i].origin = from.vec(i);
        rays[i].direction = towards.vec(i);
        rays[i].t_max = transport::infinity;
    }
    return trace(std::move(rays), of, false);
}

std::shared_ptr<Points> Batch::trace(std::vector<Ray> rays, std::vector<std::uint32_t> rows, bool first) {
    auto made = std::make_shared<Points>();
    made->batch = shared_from_this();
    const std::uint32_t key = first_free_dimension + most_dimensions + depth_++;
    (first ? counters().camera_rays : counters().scattering_rays) += rays.size();
    unlocked(*this, [&] {
        const transport::EmbreeScene& geometry = *scene().geometry;
        std::vector<Hit> hits(rays.size());
        geometry.intersect(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].valid()) {
                made->missed.push_back(rows[i]);
                made->missed_rays.push_back(rays[i]);
                continue;
            }
            made->rows.push_back(rows[i]);
            made->rays.push_back(rays[i]);
            made->hits.push_back(hits[i]);
        }
        made->points.resize(made->rows.size());
        made->sources.resize(made->rows.size());
        made->bsdfs.resize(made->rows.size());
        geometry.surfaces(made->rays, made->hits, made->points, made->sources);
        for (std::size_t i = 0; i < made->count(); ++i) {
            made->points[i].random_key = camera().samplers[made->rows[i]].key(key);
            made->points[i].services = {&display(), static_cast<std::int32_t>(made->rows[i]), depth_ - 1};
        }
        if (scene().materials->turns_normals()) transport::apply_bump(scene(), made->hits, made->points);
        scene().materials->shade(*scene().textures, made->points, made->bsdfs);
    });
    if (!first) return made;
    for (std::size_t i = 0; i < made->count(); ++i) {
        const auto row = static_cast<int>(made->rows[i]);
        display().write_distance(row, transport::to_float(made->hits[i].t));
        display().write_opacity(row, 1.0f);
        display().write_surface(row, scene().geometry->surface_number(made->hits[i]));
    }
    if (context_.first_hits.aovs->inputs() == 0 || made->rows.empty()) return made;
    std::vector<std::uint32_t> all(made->count());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    geoaovs::ShadingBatch shading;
    transport::describe_first_hits(
        context_, {all, made->rows, made->rays, made->hits, made->points, made->sources, made->bsdfs}, shading);
    context_.first_hits.aovs->write(shading, display());
    return made;
}

py::array_t<bool> Batch::live() const {
    check();
    return truths_of(count(), [&](std::size_t i) { return services_.lpe.live(paths_[i]); });
}

void Batch::scatter(const Points& points, const std::vector<transport::LobeList>& lobes) {
    check_own(points);
    if (lobes.size() != points.count())
        fail("the scattering has " + std::to_string(lobes.size()) + " points; expected " +
             std::to_string(points.count()));
    transport::LobeParts parts;
    for (std::size_t i = 0; i < points.count(); ++i)
        services_.lpe.move(paths_[points.rows[i]],
                           lobe_parts(*context_.events, points.sources[i].label, lobes[i], parts));
}

void Batch::contribute(std::uint32_t row, const Points* points, std::size_t i, const transport::LobeList* lobes,
                       std::uint32_t light, const transport::Rgb& value) {
    check();
    display::Tracker path = paths_[row];
    transport::LobeParts parts;
    if (lobes != nullptr)
        services_.lpe.move(path, lobe_parts(*context_.events, points->sources[i].label, *lobes, parts));
    services_.lpe.move(path, context_.events->terminal(light));
    services_.lpe.contribute(transport::to_float(value), display::Technique{lobes != nullptr ? 1U : 0U, 2}, path);
}

std::vector<transport::LobeList> Evaluation::lobes() const {
    std::vector<transport::LobeList> all;
    for (const transport::BsdfEvaluation& each : values) all.push_back(each.lobes);
    return all;
}

std::vector<transport::LobeList> Sample::lobes() const {
    std::vector<transport::LobeList> all;
    for (const transport::BsdfSample& each : samples) all.push_back(each.lobes);
    return all;
}

std::uint32_t Points::light(std::size_t i) const {
    const transport::ShapeGeometry& shape = batch->scene().geometry->shapes()[hits[i].shape];
    return shape.first_light == Hit::none ? Hit::none : shape.first_light + hits[i].primitive;
}

Ray Points::ray_from(std::size_t i, const Vec3& direction) const {
    Ray ray;
    ray.origin =
        transport::offset_ray_origin(points[i].position, points[i].geometric_normal, sources[i].offset.here, direction);
    ray.direction = direction;
    ray.time = hits[i].time;
    ray.cone = hits[i].cone;
    return ray;
}

py::array_t<float> Points::emitted() const {
    return triples_of(count(), [&](std::size_t i) {
        const std::uint32_t from = light(i);
        if (from == Hit::none) return Vec3();
        return vec_of(batch->scene().lights->emitted(from, points[i], points[i].wo));
    });
}

std::shared_ptr<Evaluation> Points::evaluate(const py::object& wi) const {
    const Triples directions(wi, count(), "wi");
    auto made = std::make_shared<Evaluation>();
    unlocked(*batch, [&] {
        for (std::size_t i = 0; i < count(); ++i)
            made->values.push_back(bsdfs[i].evaluate(points[i].wo, directions.vec(i)));
    });
    return made;
}

std::shared_ptr<Sample> Points::sample(const py::object& choice, const py::object& numbers) const {
    const Array<float> lobe = array_of<float>(choice, "choice"), u = array_of<float>(numbers, "numbers");
    check_shape(lobe, count(), 0, "choice");
    check_shape(u, count(), 2, "numbers");
    auto made = std::make_shared<Sample>();
    unlocked(*batch, [&] {
        for (std::size_t i = 0; i < count(); ++i)
            made->samples.push_back(
                bsdfs[i].sample(points[i].wo, lobe.data()[i], {u.data()[2 * i], u.data()[2 * i + 1]}));
    });
    return made;
}

std::shared_ptr<LightSamples> Points::sample_light(const py::object& choice, const py::object& numbers) const {
    const Array<float> which = array_of<float>(choice, "choice"), u = array_of<float>(numbers, "numbers");
    check_shape(which, count(), 0, "choice");
    check_shape(u, count(), 2, "numbers");
    auto made = std::make_shared<LightSamples>();
    made->from = shared_from_this();
    made->samples.resize(count());
    const transport::LightTable& lights = *batch->scene().lights;
    const transport::LightChooser& chooser = lights.chooser(transport::LightChoice::light_sampling);
    if (chooser.empty()) return made;
    unlocked(*batch, [&] {
        for (std::size_t i = 0; i < count(); ++i) {
            transport::LightSample& sample = made->samples[i];
            if (!lights.sample(chooser, *batch->scene().geometry, {points[i].position, points[i].shading_normal},
                               which.data()[i], {u.data()[2 * i], u.data()[2 * i + 1]}, sample))
                sample = {};
        }
    });
    return made;
}

py::array_t<bool> Points::occluded(const py::object& directions, double distance) const {
    const Triples towards(directions, count(), "directions");
    std::vector<std::uint8_t> blocked(count());
    batch->counters().shadow_rays += count();
    unlocked(*batch, [&] {
        std::vector<Ray> shadow;
        for (std::size_t i = 0; i < count(); ++i) {
            shadow.push_back(ray_from(i, towards.vec(i)));
            shadow.back().t_max = static_cast<transport::Real>(distance);
        }
        batch->scene().geometry->occluded(shadow, blocked);
    });
    return truths_of(count(), [&](std::size_t i) { return blocked[i] != 0; });
}

py::array_t<bool> visible(const LightSamples& lights) {
    const Points& from = *lights.from;
    std::vector<std::uint8_t> blocked(from.count(), 1);
    unlocked(*from.batch, [&] {
        std::vector<Ray> shadow;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < from.count(); ++i) {
            if (!(lights.samples[i].pdf > 0)) continue;
            shadow.push_back(transport::shadow_ray(from.points[i].position, from.points[i].geometric_normal,
                                                   from.sources[i].offset.here, lights.samples[i]));
            shadow.back().time = from.hits[i].time;
            which.push_back(i);
        }
        std::vector<std::uint8_t> found(shadow.size());
        from.batch->scene().geometry->occluded(shadow, found);
        for (std::size_t i = 0; i < which.size(); ++i) blocked[which[i]] = found[i];
        from.batch->counters().shadow_rays += shadow.size();
    });
    return truths_of(from.count(), [&](std::size_t i) { return blocked[i] == 0; });
}

std::shared_ptr<Points> Points::go_on(const Sample& sample, const py::object& keep) const {
    if (sample.samples.size() != count())
        fail("the sample has " + std::to_string(sample.samples.size()) + " points; expected " +
             std::to_string(count()));
    std::vector<std::uint8_t> kept(count(), 1);
    if (!keep.is_none()) {
        const Array<bool> mask = array_of<bool>(keep, "keep");
        check_shape(mask, count(), 0, "keep");
        std::copy(mask.data(), mask.data() + count(), kept.begin());
    }
    std::vector<Ray> onward;
    std::vector<std::uint32_t> of;
    for (std::size_t i = 0; i < count(); ++i) {
        if (kept[i] == 0 || !(sample.samples[i].pdf > 0)) continue;
        onward.push_back(ray_from(i, sample.samples[i].wi));
        of.push_back(rows[i]);
    }
    return batch->trace(std::move(onward), std::move(of), false);
}

}  // namespace raylex::python
