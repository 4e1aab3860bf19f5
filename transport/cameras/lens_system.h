// Spherical lens elements one behind another, as lens files list them, and rays through them (Kolb, Mitchell and
// Hanrahan 1995, "A Realistic Camera Model for Computer Graphics"; "Physically Based Rendering", 4th edition, section
// 5.3). All lengths in metres. The film is the plane z = 0, elements stand before it along +z.
#pragma once

#include <string>
#include <vector>

#include "transport/cameras/aperture.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

struct LensElement {
    double curvature = 0;  ///< radius, positive if the centre is on the film's side; 0: the stop, or a plane
    double thickness = 0;  ///< to the next element towards the film; for the last element: to the film
    double eta = 1;        ///< index of refraction behind it, towards the film; 0 in files counts as 1
    double radius = 0;     ///< of the opening
};

struct LensRay {
    DVec3 origin, direction;
};

class LensSystem {
  public:
    /// Reads a lens file with elements from the front to the film. `stop_diameter` (metres) replaces the diameter of
    /// the stop in the file, unless the file's is smaller; 0: the file's.
    static Result<LensSystem> read(const std::string& path, double stop_diameter, Aperture aperture,
                                   const SourceLocation& named_at, std::vector<Error>& warnings);

    /// Moves the lens so that points on the axis at `distance` before the film are in focus, by paraxial rays.
    Status focus(double distance, const SourceLocation& where);
    /// Traces `ray` from the film through all elements (direction.z > 0); `ray` becomes the ray that leaves at the
    /// front. Returns the transmittance: 0 where an opening stops the ray or it is totally reflected.
    [[nodiscard]] double trace(LensRay& ray) const;

    [[nodiscard]] double rear_z() const { return elements_.back().thickness; }
    [[nodiscard]] double rear_radius() const { return elements_.back().radius; }
    [[nodiscard]] const std::vector<LensElement>& elements() const { return elements_; }

  private:
    std::vector<LensElement> elements_;
    Aperture aperture_;
};

}  // namespace raylex::transport
