// What an integrator in Python works on: a batch of camera rays, and the surface points that rays of it found. All of
// it arrays with a row for each ray or point; C++ does per ray what experiments/plugins/planted_error.cpp does.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/call_scope.h"
#include "transport/integrators/integrator.h"
#include "transport/paths/first_hits.h"

namespace raylex::python {

class Points;

/// One call of integrate(); no use after it.
class Batch : public CallScope, public std::enable_shared_from_this<Batch> {
  public:
    Batch(const transport::CameraBatch& camera, const transport::IntegratorContext& context,
          transport::IntegratorThread& thread, transport::ThreadServices& services);

    [[nodiscard]] std::size_t count() const { return camera().rays.size(); }
    [[nodiscard]] const transport::CameraBatch& camera() const {
        check();
        return camera_;
    }
    [[nodiscard]] const transport::SceneView& scene() const {
        check();
        return context_.scene;
    }
    [[nodiscard]] transport::IntegratorCounters& counters() const {
        check();
        return thread_.counters;
    }
    [[nodiscard]] display::DisplayServices& display() const {
        check();
        return services_.display;
    }

    /// Numbers of the samples of these rows; None: all. (rows,) and (rows, 2).
    [[nodiscard]] py::array_t<float> numbers(std::uint32_t dimension, const py::object& rows) const;
    [[nodiscard]] py::array_t<float> numbers_2d(std::uint32_t dimension, const py::object& rows) const;

    // All of them are errors once the batch is over.

    /// The camera's rays, and any other: row r[i] of the batch sends one from origins[i] in directions[i].
    std::shared_ptr<Points> trace();
    std::shared_ptr<Points> trace_rays(const py::object& origins, const py::object& directions, const py::object& rows);
    std::shared_ptr<Points> trace(std::vector<transport::Ray> rays, std::vector<std::uint32_t> rows, bool first);

    /// Whether anything that the path of each row may still meet counts.
    [[nodiscard]] py::array_t<bool> live() const;
    /// Errors: points of another batch, whose rows this one may not have.
    void check_own(const Points& points) const;
    /// One event along each path: the scattering towards light that a sample or evaluation was of.
    void scatter(const Points& points, const std::vector<transport::LobeList>& lobes);
    void contribute(std::uint32_t row, const Points* points, std::size_t i, const transport::LobeList* lobes,
                    std::uint32_t light, const transport::Rgb& value);
    [[nodiscard]] std::vector<std::uint32_t> rows_of(const py::object& rows) const;

  private:
    const transport::CameraBatch& camera_;
    const transport::IntegratorContext& context_;
    transport::IntegratorThread& thread_;
    transport::ThreadServices& services_;
    std::vector<display::Tracker> paths_;  // by row
    std::uint32_t depth_ = 0;              // batches of rays traced so far
};

/// What a light sample of each point is; pdf 0 where there is none.
struct LightSamples {
    std::shared_ptr<const Points> from;
    std::vector<transport::LightSample> samples;
};
/// f |cos| towards a direction for each point.
struct Evaluation {
    std::vector<transport::BsdfEvaluation> values;
    [[nodiscard]] std::vector<transport::LobeList> lobes() const;
};
/// A direction drawn for each point.
struct Sample {
    std::vector<transport::BsdfSample> samples;
    [[nodiscard]] std::vector<transport::LobeList> lobes() const;
};

class Points : public std::enable_shared_from_this<Points> {
  public:
    std::shared_ptr<Batch> batch;
    std::vector<std::uint32_t> rows, missed;        ///< of the batch: with a point, and those whose ray hit nothing
    std::vector<transport::Ray> rays, missed_rays;  ///< that found the points, and the others
    std::vector<transport::Hit> hits;
    std::vector<transport::SurfacePoint> points;
    std::vector<transport::SurfaceSource> sources;
    std::vector<transport::Bsdf> bsdfs;

    [[nodiscard]] std::size_t count() const { return rows.size(); }
    /// The light of the surface itself; Hit::none where it does not shine.
    [[nodiscard]] std::uint32_t light(std::size_t i) const;
    [[nodiscard]] transport::Ray ray_from(std::size_t i, const transport::Vec3& direction) const;

    [[nodiscard]] py::array_t<float> emitted() const;
    [[nodiscard]] std::shared_ptr<Evaluation> evaluate(const py::object& wi) const;
    [[nodiscard]] std::shared_ptr<Sample> sample(const py::object& choice, const py::object& numbers) const;
    [[nodiscard]] std::shared_ptr<LightSamples> sample_light(const py::object& choice, const py::object& numbers) const;
    [[nodiscard]] py::array_t<bool> occluded(const py::object& directions, double distance) const;
    [[nodiscard]] std::shared_ptr<Points> go_on(const Sample& sample, const py::object& keep) const;
};

/// Whether light of the samples arrives: nothing stands in the way.
py::array_t<bool> visible(const LightSamples& lights);

/// What `value(i)` gives for each of `count`, as (count, 3).
template <class Value>
py::array_t<float> triples_of(std::size_t count, Value value) {
    std::vector<float> numbers;
    numbers.reserve(3 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto v = value(i);
        numbers.insert(numbers.end(), {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])});
    }
    return owning_array(std::move(numbers), {static_cast<py::ssize_t>(count), 3});
}
template <class T, class Value>
py::array_t<T> column_of(std::size_t count, Value value) {
    std::vector<T> numbers;
    numbers.reserve(count);
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(static_cast<T>(value(i)));
    return owning_array(std::move(numbers), {static_cast<py::ssize_t>(count)});
}
/// The same of truths: std::vector<bool> has no memory to hand out.
template <class Value>
py::array_t<bool> truths_of(std::size_t count, Value value) {
    py::array_t<bool> array(static_cast<py::ssize_t>(count));
    for (std::size_t i = 0; i < count; ++i) array.mutable_data()[i] = static_cast<bool>(value(i));
    return array;
}

}  // namespace raylex::python
