// Sample filters in Python: display/services/samples/sample_filter.h with the samples of a batch as arrays that are
// changed in place.
#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "display/services/samples/sample_filter.h"
#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/plugins/plugin_parts.h"
#include "experiments/python/bindings/plugins/python_object.h"

namespace raylex::python {

using namespace pybind11::literals;
using display::ChannelId;

namespace {

/// The samples of a batch. They are invalid after apply().
class Samples {
  public:
    Samples(display::SampleTable& table, ChannelId beauty) : table_(&table), beauty_(beauty) {}
    /// Writes the changes of a filter to the table, as written values.
    void end() {
        for (const auto& [id, copy] : copies_) {
            const auto components = static_cast<std::size_t>(display::component_count(table().channel(id).type));
            for (int row = 0; row < table().row_count(); ++row) {
                const std::size_t at = static_cast<std::size_t>(row) * components;
                const double* const now = copy->data() + at;
                if (std::memcmp(now, table().values(id) + at, components * sizeof(double)) != 0)
                    std::copy_n(now, components, table().edit(id, row).begin());
            }
        }
        table_ = nullptr;
    }

    [[nodiscard]] std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (int i = 0; i < table().channel_count(); ++i)
            if (display::takes_samples(table().channel(i))) names.push_back(name_of(i));
        return names;
    }
    /// Returns values of shape (rows, components), or (rows,) for single numbers: a copy for end(), because Python may
    /// keep it longer than the table exists.
    [[nodiscard]] py::array_t<double> values(const std::string& name) {
        for (ChannelId id = 0; id < table().channel_count(); ++id) {
            if (name_of(id) != name || !display::takes_samples(table().channel(id))) continue;
            table().touch(id);
            const int components = display::component_count(table().channel(id).type);
            std::vector<py::ssize_t> shape{table().row_count()};
            if (components != 1) shape.push_back(components);
            const double* const values = table().values(id);
            Copy& copy = copies_[id];
            if (!copy) copy = std::make_shared<std::vector<double>>(values, values + table().row_count() * components);
            const py::capsule owner(new Copy(copy), [](void* p) { delete static_cast<Copy*>(p); });
            return py::array_t<double>(std::move(shape), copy->data(), owner);
        }
        fail("unknown channel '" + name + "' in the samples", near_miss(name, names()));
    }
    [[nodiscard]] py::array_t<std::int32_t> pixels() const {
        std::vector<std::int32_t> xy;
        for (int row = 0; row < table().row_count(); ++row)
            xy.insert(xy.end(), {table().camera_row(row).pixel_x, table().camera_row(row).pixel_y});
        return owning_array(std::move(xy), {table().row_count(), 2});
    }
    [[nodiscard]] int rows() const { return table().row_count(); }

  private:
    using Copy = std::shared_ptr<std::vector<double>>;
    [[nodiscard]] display::SampleTable& table() const {
        if (table_ == nullptr) fail("these samples are no longer valid; they can be used only within apply()");
        return *table_;
    }
    [[nodiscard]] std::string name_of(ChannelId id) const {
        return id == beauty_ ? "beauty" : table().channel(id).name;
    }
    display::SampleTable* table_;
    ChannelId beauty_;
    std::map<ChannelId, Copy> copies_;  // of the channels that were read
};

class PythonFilter final : public display::SampleFilter {
  public:
    PythonFilter(py::object object, const display::SampleFilterContext& context)
        : beauty_(context.beauty), control_(RunControl::current()) {
        // Without keeps_splits, a filter is assumed to change each layer differently.
        const py::object keeps = py::getattr(object, "keeps_splits", py::bool_(false));
        if (!py::bool_(keeps))
            for (std::size_t i = 0; i < context.channels.size(); ++i) alters_.push_back(static_cast<ChannelId>(i));
        object_ = std::make_unique<Held>(std::move(object));
    }
    void apply(display::SampleTable& table) const override {
        guarded_call(control_, [&] {
            const auto samples = std::make_shared<Samples>(table, beauty_);
            const std::unique_ptr<Samples, void (*)(Samples*)> ends(samples.get(), [](Samples* s) { s->end(); });
            (**object_).attr("apply")(samples);
        });
    }
    [[nodiscard]] std::vector<ChannelId> alters() const override { return alters_; }

  private:
    std::unique_ptr<Held> object_;
    ChannelId beauty_;
    std::vector<ChannelId> alters_;
    std::shared_ptr<RunControl> control_;
};

void register_filter(const std::string& name, const py::object& type, const std::string& help,
                     const py::dict& defaults) {
    auto& registry = display::sample_filter_registry();
    const auto python = describe_class("sample filter", name, help, type, defaults);
    claim_name("sample filter", name, registry.find(name) != nullptr);
    registry.add(
        {name, help, python->parameters,
         [python](const ParameterSet& parameters,
                  const display::SampleFilterContext& context) -> Result<std::unique_ptr<display::SampleFilter>> {
             const Callback locked;
             transport::ParameterReader reader(parameters);
             auto object = make_instance(*python, reader);
             if (!object) return object.error();
             return std::unique_ptr<display::SampleFilter>(std::make_unique<PythonFilter>(*std::move(object), context));
         }});
}

}  // namespace

void add_filters(py::module_& module) {
    py::class_<Samples, std::shared_ptr<Samples>>(
        module, "Samples",
        "The samples of a batch before the pixel filter, as arrays that a sample filter changes in place.")
        .def_property_readonly("names", &Samples::names, "names of the channels, including 'beauty'")
        .def_property_readonly("pixels", &Samples::pixels, "int32 (rows, 2): x, y of each sample's pixel")
        .def("__len__", &Samples::rows)
        .def("__getitem__", &Samples::values, "name"_a,
             "float64 (rows, components), or (rows,) for single numbers. Writing changes the samples.");
    module.def("_register_sample_filter", &register_filter, "name"_a, "type"_a, "help"_a, "defaults"_a);
}

}  // namespace raylex::python
