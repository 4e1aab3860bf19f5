// Ambient occlusion: the share of the sky that a point sees within a distance. pbrt scenes ask for it by this name.
#include "transport/plugins/plugin.h"
using namespace raylex;
using namespace raylex::transport;

struct AmbientOcclusion : Integrator {
    float distance = infinity;
    IntegratorContext scene;
    Status prepare(const IntegratorContext& context) override { return scene = context, success(); }
    void integrate(const CameraBatch& camera, IntegratorThread&, ThreadServices& services) const override {
        const EmbreeScene& geometry = *scene.scene.geometry;
        for (int row = 0; const Ray& ray : camera.rays) {
            const PixelSampler& sampler = camera.samplers[static_cast<std::size_t>(row)];
            display::Tracker path = services.lpe.begin(row);
            Hit hit[1];
            SurfacePoint point[1];
            SurfaceSource source[1];
            std::uint8_t blocked[1];
            geometry.intersect({&ray, 1}, hit);
            if (const int here = row++; hit->valid()) {
                geometry.surfaces({&ray, 1}, hit, point, source);
                services.display.write_distance(here, hit->t);
                services.display.write_opacity(here, 1.0f);
                const Frame frame = Frame::from_normal(face_forward(point->shading_normal, point->wo));
                const Vec3 up = frame.to_world(sample_cosine_hemisphere(sampler.get_2d(first_free_dimension)));
                const Ray out{offset_ray_origin(point->position, point->geometric_normal, source->offset.here, up),
                              distance, up};
                geometry.occluded({&out, 1}, blocked);
                services.lpe.move(path, scene.events->scatter(source->label, lobes::diffuse));
                services.lpe.move(path, scene.events->user_terminal());
                if (!*blocked) services.lpe.contribute(Rgb(1), display::Technique{}, path);
            }
        }
    }
};
RAYLEX_PLUGIN(host) {
    host.add_integrator(
        {"ambientocclusion",
         "the share of the sky that a point sees",
         {{"maxdistance", ParameterType::real, "infinite", "how far away a surface still hides the sky, > 0"}},
         [](const SceneEntity& entity, auto) -> Result<std::unique_ptr<Integrator>> {
             ParameterReader reader(entity.parameters);
             auto made = std::make_unique<AmbientOcclusion>();
             made->distance = reader.real("maxdistance", infinity, 1e-30f, infinity);
             if (reader.error()) return *reader.error();
             return std::unique_ptr<Integrator>(std::move(made));
         }});
}
