#include "experiments/python/bindings/plugins/services.h"

#include "display/services/samples/display_services.h"
#include "experiments/python/bindings/plugins/batch.h"

namespace raylex::python {

using namespace pybind11::literals;
using display::ChannelType;

namespace {

template <class Value>
bool send(display::DisplayServices& services, display::ChannelId id, int row, const Value& value, Sending how) {
    if constexpr (std::is_same_v<Value, std::int32_t>) return services.write(id, row, value);
    else return how == Sending::splat ? services.splat(id, row, value) : services.write(id, row, value);
}

std::vector<int> rows_of(const Batch& batch, const py::object& rows) {
    batch.check();  // empty rows are an error too after the call
    if (rows.is_none()) {
        const std::vector<std::uint32_t> all = batch.rows_of(rows);
        return {all.begin(), all.end()};
    }
    const Array<std::int32_t> array = array_of<std::int32_t>(rows, "rows");
    check_shape(array, static_cast<std::size_t>(array.size()), 0, "rows");
    return {array.data(), array.data() + array.size()};
}

Array<float> numbers_of(const py::object& values, std::size_t count, const char* what) {
    const Array<float> array = array_of<float>(values, what);
    if (array.ndim() == 0) return array_of<float>(py::module_::import("numpy").attr("full")(count, values), what);
    check_shape(array, count, 0, what);
    return array;
}

void write_distance(Batch& batch, const py::object& distance, const py::object& of) {
    const std::vector<int> rows = rows_of(batch, of);
    const Array<float> values = numbers_of(distance, rows.size(), "distance");
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (!batch.display().write_distance(rows[i], values.data()[i]))
            fail("a distance or row is invalid; expected finite numbers and rows of this batch");
}

void write_opacity(Batch& batch, const py::object& opacity, const py::object& of) {
    const std::vector<int> rows = rows_of(batch, of);
    const Triples values(opacity, rows.size(), "opacity");
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (!batch.display().write_opacity(rows[i], transport::to_float(values[i])))
            fail("an opacity or row is invalid; expected numbers from 0 to 1 and rows of this batch");
}

py::array_t<std::int32_t> add_rows(Batch& batch, const py::object& depth, const py::object& opacity,
                                   const py::object& of, bool volume) {
    const std::vector<int> rows = rows_of(batch, of);
    const Array<float> depths = numbers_of(depth, rows.size(), "depth");
    const Triples opacities(opacity, rows.size(), "opacity");
    return column_of<std::int32_t>(rows.size(), [&](std::size_t i) {
        return batch.display().add_sample(rows[i], {depths.data()[i], RgbD(transport::to_float(opacities[i])), volume});
    });
}

}  // namespace

void send_values(display::DisplayServices& services, const std::string& name, const std::vector<int>& rows,
                 const py::object& values, Sending how) {
    const auto channels = services.get_display_channels();
    const display::ChannelId id = display::find_channel(channels, name);
    if (id == display::invalid_channel) return;
    const auto channel =
        std::find_if(channels.begin(), channels.end(), [&](const auto& each) { return each.id == id; });
    const std::string what = "the value for channel '" + name + "'";
    bool all = true;
    const auto each = [&](auto value_of) {
        for (std::size_t i = 0; i < rows.size(); ++i) all &= send(services, id, rows[i], value_of(i), how);
    };
    if (channel->type == ChannelType::integer) {
        if (how == Sending::splat) fail("channel '" + name + "' holds integers, which can be written but not splatted");
        const Array<std::int32_t> numbers = array_of<std::int32_t>(values, what);
        check_shape(numbers, rows.size(), 0, what);
        each([&](std::size_t i) { return numbers.data()[i]; });
    } else if (channel->type == ChannelType::real) {
        const Array<float> numbers = numbers_of(values, rows.size(), what.c_str());
        each([&](std::size_t i) { return numbers.data()[i]; });
    } else {
        const Triples triples(values, rows.size(), what);
        each([&](std::size_t i) { return transport::to_float(triples[i]); });
    }
    if (!all) fail(what + " is partly invalid; expected finite numbers and rows of this batch");
}

py::array_t<bool> TextureServices::seen() const {
    check();
    return truths_of(points_.size(), [&](std::size_t i) { return points_[i].services.camera_sees(); });
}

py::array_t<std::int32_t> TextureServices::depth() const {
    check();
    return column_of<std::int32_t>(points_.size(), [&](std::size_t i) {
        const transport::VertexServices& services = points_[i].services;
        return services.display == nullptr ? -1 : static_cast<std::int32_t>(services.depth);
    });
}

void TextureServices::write(const std::string& name, const py::object& values) const {
    const Use use(*this);  // NumPy releases Python's lock during the conversion
    std::vector<int> rows;
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        if (!points_[i].services.camera_sees()) continue;
        rows.push_back(points_[i].services.row);
        seen.push_back(i);
    }
    if (rows.empty()) return;
    const py::object array = py::module_::import("numpy").attr("asarray")(values);
    const bool one = array.attr("ndim").cast<int>() == 0;
    const py::object of_seen = one ? array : array.attr("__getitem__")(py::cast(seen));
    send_values(*points_[seen.front()].services.display, name, rows, of_seen, Sending::write);
}

void add_services(py::module_& module) {
    auto batch = module.attr("Batch").cast<py::class_<Batch, std::shared_ptr<Batch>>>();
    batch
        .def_property_readonly(
            "channels",
            [](const Batch& b) {
                std::vector<std::string> names;
                for (const auto& each : b.display().get_display_channels()) names.push_back(each.name);
                return py::tuple(py::cast(names));
            },
            "names of the render's channels")
        .def(
            "write",
            [](Batch& b, const std::string& name, const py::object& values, const py::object& rows) {
                const Batch::Use use(b);
                send_values(b.display(), name, rows_of(b, rows), values, Sending::write);
            },
            "name"_a, "values"_a, "rows"_a = py::none(),
            "Replaces the values of rows in a channel: (rows,), or (rows, 3) for channels of triples. Does nothing if "
            "the channel was not requested.")
        .def(
            "splat",
            [](Batch& b, const std::string& name, const py::object& values, const py::object& rows) {
                const Batch::Use use(b);
                send_values(b.display(), name, rows_of(b, rows), values, Sending::splat);
            },
            "name"_a, "values"_a, "rows"_a = py::none(),
            "Adds to the values of rows in a channel; arguments as for write().")
        .def("write_distance", &write_distance, "distance"_a, "rows"_a = py::none(),
             "Writes the distance along the camera ray, in world units, for depth and deep images.")
        .def("write_opacity", &write_opacity, "opacity"_a, "rows"_a = py::none(),
             "Writes the opacity of rows, 0 to 1, one number or three, for alpha and deep alpha.")
        .def("add_samples", &add_rows, "depth"_a, "opacity"_a, "rows"_a = py::none(), "volume"_a = false,
             "Adds a row to the camera ray of each of `rows`, for surfaces and volumes behind one another. Returns the "
             "new rows, int32.")
        .def(
            "discard", [](Batch& b) { return b.display().discard_iteration(); },
            "Drops everything that this call of integrate() sends, before and after.");
    py::class_<TextureServices, std::shared_ptr<TextureServices>>(
        module, "TextureServices",
        "The values that a texture can write at its evaluated points. They are invalid after the call.")
        .def_property_readonly("seen", &TextureServices::seen,
                               "bool (points,): whether the camera sees the point directly")
        .def_property_readonly(
            "depth", &TextureServices::depth,
            "int32 (points,): number of scattering events between camera and point; -1: nothing can be written")
        .def("write", &TextureServices::write, "name"_a, "values"_a,
             "Writes to a channel at the points that the camera sees: (points,), or (points, 3) for channels of "
             "triples.");
}

}  // namespace raylex::python
