// Checks the handles of calls, and whether the builder still accepts calls.
#include <atomic>

#include "transport/import/builder/scene_builder.h"
#include "transport/import/builder/settled_transform.h"

namespace raylex::transport {

std::uint32_t SceneBuilder::next_id() {
    static std::atomic<std::uint32_t> last{0};
    return ++last;
}

Status SceneBuilder::check_open(const SourceLocation& where) const {
    if (!spent_) return success();
    return error_at(where, "finish() has been called and the scene builder is spent; expected a new one");
}

template <typename Handle>
Status SceneBuilder::check_handle(const Handle& handle, const char* what, const SourceLocation& where) const {
    if (handle.builder == id_ || (handle.builder == 0 && handle.reference == Handle().reference)) return success();
    if (handle.builder == 0)
        return error_at(where, std::string("the ") + what +
                                   " is a handle that no scene builder returned; expected one of this builder");
    return error_at(
        where, std::string("the ") + what + " belongs to another scene builder; expected a handle of this builder");
}

template Status SceneBuilder::check_handle(const MediumHandle&, const char*, const SourceLocation&) const;

Status SceneBuilder::check_placement(const ShapePlacement& placement, const SourceLocation& where) const {
    if (Status s = check_open(where); !s) return s;
    if (Status s = check_handle(placement.material, "material", where); !s) return s;
    if (Status s = check_handle(placement.area_light, "area light", where); !s) return s;
    if (Status s = check_handle(placement.inside, "medium inside", where); !s) return s;
    if (Status s = check_handle(placement.outside, "medium outside", where); !s) return s;
    if (Status s = check_handle(placement.object, "object", where); !s) return s;
    return check_finite(placement.to_world, where);
}

Status SceneBuilder::check_instance(ObjectHandle object, const Transform& to_world, const SourceLocation& where) const {
    if (Status s = check_open(where); !s) return s;
    if (Status s = check_handle(object, "object", where); !s) return s;
    if (object.reference < 0) return error_at(where, "an instance of no object; expected one that was added or named");
    return check_finite(to_world, where);
}

}  // namespace raylex::transport
