// A sampler of directions that learned where light comes from: the mixture of a closure's density and of a GuideTree's.
//
// One number chooses which of the two draws a direction; the density is that of the mixture (one-sample multiple
// importance sampling with the balance heuristic; Veach 1997, section 9.2.4). Some closures draw all their
// directions themselves (Bsdf::can_be_guided).
#pragma once

#include "transport/paths/direction_sampler.h"
#include "transport/paths/guide/guide_tree.h"

namespace raylex::transport {

/// Guides paths of radiance. Paths of importance are drawn by closures.
class Guide final : public DirectionSampler {
  public:
    explicit Guide(GuideTree tree) : tree_(std::move(tree)) {}
    [[nodiscard]] const GuideTree& tree() const { return tree_; }
    /// Not while paths are drawn.
    void set_tree(GuideTree tree) { tree_ = std::move(tree); }
    /// Paths teach the guide: where its tree plans rays, at least a quarter of them go on, and vertices take all light
    /// samples. Not while paths are drawn.
    void set_training(bool training) { training_ = training; }

    void locate(std::span<SurfacePoint> points) const override;
    [[nodiscard]] bool plans_rays() const override { return tree_.plans_rays(); }
    [[nodiscard]] Real rays(const Bsdf& bsdf, const SurfacePoint& point, Real throughput) const override;
    [[nodiscard]] Real light_share(const SurfacePoint& point, Real throughput) const override;
    [[nodiscard]] BsdfSample sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, Real u_lobe,
                                    const Vec2& u) const override;
    [[nodiscard]] Real pdf(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, const Vec3& to,
                           Real closure_pdf) const override;

  private:
    /// The region of a point; null: the closure draws the direction.
    [[nodiscard]] const GuideTree::Region* region_of(const Bsdf& bsdf, const SurfacePoint& point,
                                                     TransportMode mode) const;
    [[nodiscard]] std::uint32_t region_number(const SurfacePoint& point) const;  // computed where point lacks it
    GuideTree tree_;
    bool training_ = false;
};

}  // namespace raylex::transport
