#include "transport/cameras/camera.h"
#include "transport/cameras/orthographic.h"
#include "transport/cameras/perspective.h"
#include "transport/cameras/realistic.h"
#include "transport/cameras/spherical.h"

namespace raylex::transport {

Registry<CameraFactory>& camera_registry() {
    static Registry<CameraFactory> registry = [] {
        using T = ParameterType;
        Registry<CameraFactory> r("camera");
        r.add({"perspective",
               "a pinhole, or a thin lens with depth of field",
               {{"fov", T::real, "90", "degrees that the shorter axis of the film spans"},
                {"lensradius", T::real, "0", "radius of the thin lens, in camera space; 0 is a pinhole"},
                {"focaldistance", T::real, "1000000", "distance of the plane in focus, in camera space"},
                {"frameaspectratio", T::real, "", "width over height; default: the image's"},
                {"screenwindow", T::real, "", "x min, x max, y min, y max of the film, in halves of its shorter axis"}},
               PerspectiveCamera::build});
        r.add({"orthographic",
               "parallel rays, or a telecentric lens with depth of field",
               {{"lensradius", T::real, "0", "radius of the thin lenses, in camera space; 0 is none"},
                {"focaldistance", T::real, "1000000", "distance of the plane in focus, in camera space"},
                {"frameaspectratio", T::real, "", "width over height; default: the image's"},
                {"screenwindow", T::real, "", "x min, x max, y min, y max of the film, in camera space"}},
               OrthographicCamera::build});
        r.add({"spherical",
               "all directions around a point",
               {{"mapping", T::string, "equalarea", "equalarea (octahedral) or equirectangular"}},
               SphericalCamera::build});
        r.add({"realistic",
               "a film behind the elements of a lens; not for integrators that trace paths from lights",
               {{"lensfile", T::string, "", "rows of radius, thickness, index and diameter, in millimetres"},
                {"aperturediameter", T::real, "1", "diameter of the stop, in millimetres"},
                {"focusdistance", T::real, "10", "distance from the film to the plane in focus, in metres"},
                {"aperture", T::string, "circular",
                 "shape of the stop: circular, gaussian, square, pentagon, star, or an image"}},
               RealisticCamera::build});
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
