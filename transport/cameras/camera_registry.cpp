#include "transport/cameras/camera.h"
#include "transport/cameras/perspective.h"

namespace raylex::transport {

Registry<CameraFactory>& camera_registry() {
    static Registry<CameraFactory> registry = [] {
        using T = ParameterType;
        Registry<CameraFactory> r("camera");
        r.add({"perspective",
               "a pinhole, or a thin lens with depth of field",
               {{"fov", T::real, "90", "degrees that the shorter axis of the film spans"},
                {"lensradius", T::real, "0", "of the thin lens, in camera space; 0 is a pinhole"},
                {"focaldistance", T::real, "1000000", "of the plane in focus, in camera space"},
                {"frameaspectratio", T::real, "", "width over height; default: the image's"},
                {"screenwindow", T::real, "", "x min, x max, y min, y max of the film, in halves of its shorter axis"}},
               PerspectiveCamera::build});
        return r;
    }();
    return registry;
}

}  // namespace raylex::transport
