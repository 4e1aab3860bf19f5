// The display services for plugins in Python: values of many rows in one call, by channel name.
#pragma once

#include <string>
#include <vector>

#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/call_scope.h"
#include "transport/textures/texture.h"

namespace raylex::python {

enum class Sending : std::uint8_t { write, splat };

/// Sends `values`, one per row, to the channel `name`: (rows,), or (rows, 3) for channels of triples. Does nothing if
/// the render does not have the channel. Errors: a shape that does not match; values that the services reject.
void send_values(display::DisplayServices& services, const std::string& name, const std::vector<int>& rows,
                 const py::object& values, Sending how);

/// The services of a texture in Python, for each point where it is evaluated.
class TextureServices : public CallScope {
  public:
    explicit TextureServices(std::span<const transport::TexturePoint> points)
        : CallScope("these services are no longer valid; they can be used only within evaluate()"), points_(points) {}

    /// Returns bool (points,): whether the camera sees the point directly.
    [[nodiscard]] py::array_t<bool> seen() const;
    /// Returns int32 (points,): the number of scattering events between camera and point; -1 if nothing can be written.
    [[nodiscard]] py::array_t<std::int32_t> depth() const;
    /// Writes `values`, one per point, at the points that the camera sees.
    void write(const std::string& name, const py::object& values) const;

  private:
    std::span<const transport::TexturePoint> points_;
};

void add_services(py::module_& module);

}  // namespace raylex::python
