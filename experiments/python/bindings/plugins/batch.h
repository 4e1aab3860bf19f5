// The data of an integrator in Python: a batch of camera rays, and the surface points that rays of the batch hit. All
// data are arrays with one row per ray or point; C++ does the same per ray as experiments/plugins/planted_error.cpp.
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

/// The batch of one call of integrate(). It is invalid after the call.
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

    /// Random numbers of the samples of these rows (None: all), of shape (rows,) and, in numbers_2d(), (rows, 2).
    [[nodiscard]] py::array_t<float> numbers(std::uint32_t dimension, const py::object& rows) const;
    [[nodiscard]] py::array_t<float> numbers_2d(std::uint32_t dimension, const py::object& rows) const;

    // All following functions report an error after the call.

    /// Traces the camera's rays; trace_rays() traces any rays: row r[i] of the batch sends one from origins[i] in
    /// directions[i].
    std::shared_ptr<Points> trace();
    std::shared_ptr<Points> trace_rays(const py::object& origins, const py::object& directions, const py::object& rows);
    std::shared_ptr<Points> trace(std::vector<transport::Ray> rays, std::vector<std::uint32_t> rows, bool first);

    /// Returns for each row whether any event that can follow on its path matters.
    [[nodiscard]] py::array_t<bool> live() const;
    /// Reports an error if the points belong to another batch, whose rows this batch may not have.
    void check_own(const Points& points) const;
    /// Adds one event to each path: the scattering towards light in a sample or evaluation.
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
    std::uint32_t depth_ = 0;              // number of traced batches of rays so far
};

/// A light sample for each point; pdf 0 if there is none.
struct LightSamples {
    std::shared_ptr<const Points> from;
    std::vector<transport::LightSample> samples;
};
/// f |cos| towards a direction, for each point.
struct Evaluation {
    std::vector<transport::BsdfEvaluation> values;
    [[nodiscard]] std::vector<transport::LobeList> lobes() const;
};
/// A sampled direction for each point.
struct Sample {
    std::vector<transport::BsdfSample> samples;
    [[nodiscard]] std::vector<transport::LobeList> lobes() const;
};

class Points : public std::enable_shared_from_this<Points> {
  public:
    std::shared_ptr<Batch> batch;
    std::vector<std::uint32_t> rows, missed;  ///< rows of the batch: with a point, and those whose ray hit nothing
    std::vector<transport::Ray> rays, missed_rays;  ///< rays that found the points, and the others
    std::vector<transport::Hit> hits;
    std::vector<transport::SurfacePoint> points;
    std::vector<transport::SurfaceSource> sources;
    std::vector<transport::Bsdf> bsdfs;

    [[nodiscard]] std::size_t count() const { return rows.size(); }
    /// Returns the light of the surface itself; Hit::none if it does not emit.
    [[nodiscard]] std::uint32_t light(std::size_t i) const;
    [[nodiscard]] transport::Ray ray_from(std::size_t i, const transport::Vec3& direction) const;

    [[nodiscard]] py::array_t<float> emitted() const;
    [[nodiscard]] std::shared_ptr<Evaluation> evaluate(const py::object& wi) const;
    [[nodiscard]] std::shared_ptr<Sample> sample(const py::object& choice, const py::object& numbers) const;
    [[nodiscard]] std::shared_ptr<LightSamples> sample_light(const py::object& choice, const py::object& numbers) const;
    [[nodiscard]] py::array_t<bool> occluded(const py::object& directions, double distance) const;
    [[nodiscard]] std::shared_ptr<Points> go_on(const Sample& sample, const py::object& keep) const;
};

/// Returns for each sample whether its light is unoccluded.
py::array_t<bool> visible(const LightSamples& lights);

/// Returns `value(i)` for each of `count`, as an array of shape (count, 3).
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
/// Returns `value(i)` for each of `count` as an array of bool. std::vector<bool> has no contiguous memory.
template <class Value>
py::array_t<bool> truths_of(std::size_t count, Value value) {
    py::array_t<bool> array(static_cast<py::ssize_t>(count));
    for (std::size_t i = 0; i < count; ++i) array.mutable_data()[i] = static_cast<bool>(value(i));
    return array;
}

}  // namespace raylex::python
