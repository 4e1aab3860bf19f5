// The display services as plugins in Python see them: values of many rows in one call, by the names of channels.
#pragma once

#include <string>
#include <vector>

#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/call_scope.h"
#include "transport/textures/texture.h"

namespace raylex::python {

enum class Sending : std::uint8_t { write, splat };

/// Sends `values`, one for each row, to the channel `name`: (rows,), or (rows, 3) for channels of triples. A channel
/// that the render does not have takes nothing. Errors: a shape that does not fit; values that the services refuse.
void send_values(display::DisplayServices& services, const std::string& name, const std::vector<int>& rows,
                 const py::object& values, Sending how);

/// What a texture in Python writes through: the services of each point it is evaluated at.
class TextureServices : public CallScope {
  public:
    explicit TextureServices(std::span<const transport::TexturePoint> points)
        : CallScope("these services are over; expected their use within evaluate() only"), points_(points) {}

    /// bool (points,): whether the camera sees the point directly.
    [[nodiscard]] py::array_t<bool> seen() const;
    /// int32 (points,): scattering events between the camera and the point; -1 where nothing can be written.
    [[nodiscard]] py::array_t<std::int32_t> depth() const;
    /// Writes `values`, one for each point, at the points that the camera sees.
    void write(const std::string& name, const py::object& values) const;

  private:
    std::span<const transport::TexturePoint> points_;
};

void add_services(py::module_& module);

}  // namespace raylex::python
