// The normative event table of lpe/README.md, with one rendered test per row.
//
// A camera looks at one surface under a constant sky or one light. For each row, the channels of the table
// (distinguished by event, scatter letter, object and lobe label in the strict `osl` dialect) must together have all
// light of one-event paths, and each must have some. So every event is as in the table, and there is no other.
#include "endtoend/analytic.h"
#include "tests/support/folder.h"
#include "transport/measured_file.h"

using namespace raylex;
using namespace raylex::test;

namespace {

struct Row {
    const char* what;
    const char* material;             ///< pbrt Material line(s)
    std::vector<const char*> events;  ///< osl symbols expected at the first hit
};

std::string scene_text(const std::string& material, const std::string& light, const std::string& shape_extra = "") {
    return R"(
        LookAt 0 1 3  0 0 0  0 1 0
        Camera "perspective" "float fov" 20
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        WorldBegin
    )" + light +
           "\n" + material + R"(
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 -4 0 4 -4 0 4 4 0 -4 4 0] )" +
           shape_extra + "\n";
}

display::ChannelDefinition osl_channel(const std::string& name, const std::string& expression) {
    auto channel = lpe_channel(name, expression);
    channel.dialect = lpe::Dialect::osl;
    return channel;
}

/// Returns the means of the channels, in order.
std::vector<double> render_means(transport::SceneDescription scene, std::vector<display::ChannelDefinition> channels,
                                 const char* strategy = "mis") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.channels.list = std::move(channels);
    transport::SceneEntity integrator;
    integrator.type = "path";
    Parameter choice;
    choice.name = "strategy";
    choice.type = ParameterType::string;
    choice.strings = {strategy};
    integrator.parameters.parameters = {choice};
    settings.paths.integrator = integrator;
    const auto output = render_or_fail(scene, settings);
    std::vector<double> result;
    for (std::size_t i = 0; i < settings.channels.list.size(); ++i)
        result.push_back(image_mean(output, requested(output, i)).mean);
    return result;
}

const char* const constant_sky = "LightSource \"infinite\" \"rgb L\" [1 1 1]";

}  // namespace

TEST_CASE("A measured material reflects only as R G measured", "[event-table]") {
    const Folder folder;
    const std::string file = folder.write("ggx.bsdf", measured_test::file_of(measured_test::ggx(0.4, 0.4, 0.7), {}));
    auto scene = import_text(scene_text("Material \"measured\" \"string filename\" \"" + file + "\"", constant_sky));
    scene.shapes[0].label = "obj";
    const auto means =
        render_means(scene, {osl_channel("once", "C<[RTV]...>B"), osl_channel("measured", "C<RG'obj''measured'>B")});
    CHECK(means[0] > 0.3);
    CHECK(means[0] == means[1]);
}

TEST_CASE("Every material has the events of the normative table and no others", "[event-table]") {
    const std::vector<Row> rows = {
        {"diffuse", R"(Material "diffuse" "rgb reflectance" [.5 .5 .5])", {"<RD'obj''diffuse'>"}},
        {"smooth conductor", R"(Material "conductor" "float roughness" 0)", {"<RS'obj''conductor'>"}},
        {"rough conductor", R"(Material "conductor" "float roughness" 0.3)", {"<RG'obj''conductor'>"}},
        {"smooth dielectric", R"(Material "dielectric" "float eta" 1.5)", {"<RS'obj''glass'>", "<TS'obj''glass'>"}},
        {"rough dielectric",
         R"(Material "dielectric" "float eta" 1.5 "float roughness" 0.3)",
         {"<RG'obj''glass'>", "<TG'obj''glass'>"}},
        {"thin dielectric", R"(Material "thindielectric" "float eta" 1.5)", {"<RS'obj''glass'>", "<TS'obj''glass'>"}},
        {"smooth coat over diffuse",
         R"(Material "coateddiffuse" "float roughness" 0)",
         {"<RS'obj''coat'>", "<RD'obj''diffuse'>"}},
        {"rough coat over diffuse",
         R"(Material "coateddiffuse" "float roughness" 0.3)",
         {"<RG'obj''coat'>", "<RD'obj''diffuse'>"}},
        {"smooth coat over smooth conductor",
         R"(Material "coatedconductor" "float interface.roughness" 0 "float conductor.roughness" 0)",
         {"<RS'obj''coat'>", "<RS'obj''conductor'>"}},
        {"smooth coat over rough conductor",
         R"(Material "coatedconductor" "float interface.roughness" 0 "float conductor.roughness" 0.3)",
         {"<RS'obj''coat'>", "<RG'obj''conductor'>"}},
        {"rough coat over rough conductor",
         R"(Material "coatedconductor" "float interface.roughness" 0.2 "float conductor.roughness" 0.3)",
         {"<RG'obj''coat'>", "<RG'obj''conductor'>"}},
        {"mix",
         R"(MakeNamedMaterial "a" "string type" "diffuse"
            MakeNamedMaterial "b" "string type" "conductor" "float roughness" 0
            Material "mix" "string materials" ["a" "b"] "float amount" 0.5)",
         {"<RD'obj''diffuse'>", "<RS'obj''conductor'>"}},
        {"diffusetransmission", R"(Material "diffusetransmission")", {"<RD'obj''diffuse'>", "<TD'obj''diffuse'>"}},
        {"hair",
         R"(Material "hair" "rgb sigma_a" [.1 .1 .1])",
         {"<RG'obj''R'>", "<TG'obj''TT'>", "<RG'obj''TRT'>", "<RG'obj''TRRT'>"}},
        {"additive",
         R"(Material "raylex:additive" "rgb diffuse" [.3 .3 .3] "rgb specular" [.4 .4 .4] "float roughness" 0.3)",
         {"<RD'obj''diffuse'>", "<RG'obj''specular'>"}},
        {"mirror", R"(Material "raylex:mirror" "rgb reflectance" [.7 .7 .7])", {"<RS'obj''mirror'>"}},
        {"diffuse and mirror",
         R"(Material "raylex:diffuse-mirror" "rgb diffuse" [.3 .3 .3] "rgb specular" [.4 .4 .4])",
         {"<RD'obj''diffuse'>", "<RS'obj''mirror'>"}},
        {"sheet", R"(Material "raylex:sheet" "rgb transmittance" [.7 .7 .7])", {"<TS'obj''sheet'>"}},
    };
    for (const Row& row : rows) {
        auto scene = import_text(scene_text(row.material, constant_sky));
        scene.shapes[0].label = "obj";
        std::vector<display::ChannelDefinition> channels{osl_channel("one_event", "C<[RTV]...>B")};
        for (std::size_t i = 0; i < row.events.size(); ++i)
            channels.push_back(osl_channel("e" + std::to_string(i), std::string("C") + row.events[i] + "B"));
        const auto means = render_means(scene, channels);
        double sum = 0;
        for (std::size_t i = 1; i < means.size(); ++i) {
            CAPTURE(row.what, row.events[i - 1], means[i]);
            CHECK(means[i] > 1e-4);
            sum += means[i];
        }
        CAPTURE(row.what, means[0], sum);
        CHECK(std::abs(sum - means[0]) <= 1e-12 * means[0]);  // Law 1, in the double accumulators
        CHECK(means[0] > 0.01);
    }
}

TEST_CASE("A subsurface material reflects as specular, transmits as subsurface, and scatters under its own name",
          "[event-table]") {
    for (const char* roughness : {"0", "0.3"}) {
        auto scene = import_text(std::string(R"(
            Film "rgb" "integer xresolution" 8 "integer yresolution" 8
            LookAt 0 0 4  0 0 0  0 1 0
            Camera "perspective" "float fov" 20
            WorldBegin
            LightSource "infinite" "rgb L" [1 1 1]
            MakeNamedMaterial "wax" "string type" "subsurface" "rgb sigma_a" [.1 .1 .1] "rgb sigma_s" [2 2 2]
                "float roughness" )") +
                                 roughness + R"(
            NamedMaterial "wax"
            Shape "sphere")");
        const std::string reflected = roughness == std::string("0") ? "<RS'wax''specular'>" : "<RG'wax''specular'>";
        const std::string crossed = "<TD'wax''subsurface'>", inside = "[<V.'wax'>" + reflected + "]*";
        const auto means = render_means(
            scene, {osl_channel("all", "C.*B"), osl_channel("surface", "C" + reflected + "B"),
                    osl_channel("through", "C" + crossed + inside + crossed + "B"),
                    osl_channel("once", "C" + crossed + "<V.'wax'>" + crossed + "B"), osl_channel("seen", "CB"),
                    lpe_channel("shipped", "C<TD>[DSV]*[<L.>O]"), lpe_channel("number", "C<TD3'wax'>.*B")});
        CAPTURE(roughness, means[0], means[1], means[2]);
        CHECK(means[1] > 0.01);
        CHECK(means[3] > 0.01);
        CHECK(means[2] > 3 * means[3]);  // light walks: maxdepth of 5 does not count events inside
        // No other words, except light that enters again after a rough surface sent it back to the sphere.
        if (roughness == std::string("0")) CHECK(means[1] + means[2] + means[4] == Approx(means[0]).epsilon(1e-12));
        CHECK(means[5] >= means[2]);
        CHECK(means[6] >= means[2]);
    }
}

TEST_CASE("A cutout leaves a straight event in osl and no event in renderman", "[event-table]") {
    struct Row {
        std::string material;
        const char* alpha;
        double stopped;
    };
    const std::string black = "\"string type\" \"diffuse\" \"rgb reflectance\" [0 0 0] ",
                      named = "MakeNamedMaterial \"black\" " + black +
                              "MakeNamedMaterial \"border\" \"string type\" \"interface\" ";
    const Row rows[] = {
        {"Material \"diffuse\" \"rgb reflectance\" [0 0 0]", "\"float alpha\" 0.25", 0.25},
        {"Material \"interface\"", "", 0},
        {named + "Material \"mix\" \"string materials\" [\"border\" \"black\"] \"float amount\" 0.25", "", 0.25},
        {named + "Material \"mix\" \"string materials\" [\"black\" \"border\"] \"float amount\" 0.5",
         "\"float alpha\" 0.5", 0.25},
        // Half of an opacity of one half is surface to a tenth; half of one is surface to two fifths.
        {named + "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"border\" \"black\"] "
                 "\"float amount\" 0.1 "
                 "MakeNamedMaterial \"b\" \"string type\" \"mix\" \"string materials\" [\"black\" \"border\"] "
                 "\"float amount\" 0.6 Material \"mix\" \"string materials\" [\"a\" \"b\"]",
         "", 0.25},
        {named + "Material \"mix\" \"string materials\" [\"border\" \"border\"]", "", 0},
    };
    for (const auto& [material, alpha, stopped] : rows) {
        auto scene = import_text(scene_text(material.c_str(), constant_sky, alpha));
        scene.shapes[0].label = "obj";
        const auto means = render_means(scene, {osl_channel("straight", "C<Ts'obj'>B"), osl_channel("seen", "CB"),
                                                lpe_channel("renderman", "CB"), lpe_channel("all", "C.*B")});
        CAPTURE(material);
        // The black surface stops a quarter of the samples: binomial over 64 x 64 samples, 4 standard errors.
        const double expected = 1 - stopped, error = 4 * std::sqrt(stopped * expected / 4096);
        CHECK(std::abs(means[0] - expected) <= error);
        CHECK(means[1] == 0.0);
        CHECK(means[2] == means[0]);
        CHECK(means[3] == means[0]);
    }
}

TEST_CASE("A mix with an interface equals its other part with a cutout, bit for bit", "[event-table]") {
    const std::string wall = "MakeNamedMaterial \"wall\" \"string type\" \"diffuse\" ";
    const auto means_of = [&](const std::string& material, const char* alpha) {
        auto scene = import_text(scene_text(material.c_str(), constant_sky, alpha));
        return render_means(scene, {osl_channel("all", "C.*B"), osl_channel("lit", "C<RD'wall'>B")});
    };
    const auto cut = means_of(wall + "NamedMaterial \"wall\"", "\"float alpha\" 0.375");
    auto scene = import_text(scene_text((wall + "MakeNamedMaterial \"border\" \"string type\" \"interface\" "
                                                "MakeNamedMaterial \"some\" \"string type\" \"mix\" "
                                                "\"string materials\" [\"border\" \"wall\"] \"float amount\" 0.375 "
                                                "NamedMaterial \"some\"")
                                            .c_str(),
                                        constant_sky));
    scene.shapes[0].label = "wall";
    const auto mixed = render_means(scene, {osl_channel("all", "C.*B"), osl_channel("lit", "C<RD'wall'>B")});
    CHECK(mixed[0] == cut[0]);
    CHECK(mixed[1] == cut[1]);
    CHECK(mixed[1] > 0.01);
}

TEST_CASE("Light that passes a mix with an interface is in the medium behind it", "[event-table]") {
    auto scene = import_text(R"(
        MakeNamedMedium "smoke" "string type" "homogeneous" "rgb sigma_a" [.5 .5 .5] "rgb sigma_s" [0 0 0]
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        LookAt 0 0 4  0 0 0  0 1 0
        Camera "orthographic" "float screenwindow" [-.01 .01 -.01 .01]
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        MakeNamedMaterial "black" "string type" "diffuse" "rgb reflectance" [0 0 0]
        MakeNamedMaterial "border" "string type" "interface"
        MakeNamedMaterial "some" "string type" "mix" "string materials" ["border" "black"]
        NamedMaterial "some"
        MediumInterface "smoke" ""
        Shape "sphere")");
    const auto means = render_means(scene, {osl_channel("seen", "C<Ts><Ts>B"), osl_channel("all", "C.*")});
    // A quarter of the rays passes both sides of the sphere and two units of smoke, up to 1e-4 for its curvature there:
    // 64 x 64 samples, 4 standard errors.
    CHECK(std::abs(means[0] - std::exp(-1.0) / 4) <= 4 * std::exp(-1.0) * std::sqrt(0.25 * 0.75 / 4096) + 1e-4);
    CHECK(means[1] == means[0]);
}

TEST_CASE("Lights are L and the environment is B with their group, seen or sampled", "[event-table]") {
    struct LightRow {
        const char* what;
        const char* text;
        const char* letter;
        bool delta;  ///< cannot be hit
    };
    const LightRow rows[] = {
        {"point", R"(LightSource "point" "rgb I" [9 9 9] "point3 from" [0 0 2])", "L", true},
        {"spot", R"(LightSource "spot" "rgb I" [99 99 99] "point3 from" [0 0 2] "point3 to" [0 0 0])", "L", true},
        {"distant", R"(LightSource "distant" "rgb L" [2 2 2] "point3 from" [0 0 2] "point3 to" [0 0 0])", "L", true},
        {"area", "", "L", false},
        {"infinite", constant_sky, "B", false},
    };
    for (const LightRow& row : rows) {
        const bool is_area = std::string(row.what) == "area";
        auto scene = import_text(scene_text("Material \"diffuse\"", row.text));
        if (is_area) {
            // A disk that faces the surface from above. The normal of a pbrt disk is +z, so it is flipped.
            scene = import_text(scene_text("Material \"diffuse\"", R"(AttributeBegin
                ReverseOrientation
                AreaLightSource "diffuse" "rgb L" [9 9 9]
                Shape "disk" "float radius" 0.5 "float height" 2
                AttributeEnd)"));
            scene.area_lights.at(0).group = "key";
        } else {
            scene.lights.at(0).group = "key";
        }
        const std::string grouped = std::string("C<RD><") + row.letter + ".'key'>";
        const std::string other_letter = std::string(row.letter) == "L" ? "B" : "L";
        for (const char* strategy : {"mis", "light", "scattering"}) {
            if (row.delta && std::string(strategy) == "scattering") continue;
            const auto means = render_means(scene,
                                            {osl_channel("grouped", grouped), osl_channel("all", "C<RD>[LBO]"),
                                             osl_channel("other", "C<RD>" + other_letter)},
                                            strategy);
            CAPTURE(row.what, strategy, means[0], means[1]);
            CHECK(means[0] > 0.001);
            CHECK(means[0] == means[1]);
            CHECK(means[2] == 0.0);
        }
    }
}

TEST_CASE("Media scatter as V with their name, emit as O, and give no event for transmitted light", "[event-table]") {
    auto scene = import_text(R"(
        MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [.2 .2 .2] "rgb sigma_s" [.5 .5 .5] "rgb Le" [1 1 1]
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        MediumInterface "" "fog"
        Camera "perspective" "float fov" 40
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        Material "interface"
        MediumInterface "fog" ""
        Shape "sphere")");
    scene.lights.at(0).group = "sky";
    const auto means = render_means(
        scene, {osl_channel("once", "C<V.'fog'><Ts>B"), osl_channel("anyhow", "C<V.><Ts>[LBO]"),
                osl_channel("other", "C<V.><Ts>[LO]"), osl_channel("seen", "C<Ts><B.'sky'>"), osl_channel("glow", "CO"),
                osl_channel("labelled", "C.*<O.'sky'>"), osl_channel("lit", "CVO"),
                lpe_channel("renderman", "C<V.'fog'>B"), lpe_channel("everything", "C.*")});
    CHECK(means[0] > 0.05);
    CHECK(means[1] == means[0]);
    CHECK(means[7] == means[0]);
    // Light through one unit of fog, and emission along that unit, by Beer and Lambert. A collision removes the light
    // seen through the fog: 64 x 64 samples, 4.5 standard errors. The emission has no noise.
    const double through = std::exp(-0.7);
    CHECK(std::abs(means[3] - through) <= 4.5 * std::sqrt(through * (1 - through) / 4096));
    CHECK(means[4] == Approx(0.2 / 0.7 * (1 - through)).epsilon(1e-5));
    CHECK(means[5] == 0.0);
    CHECK(means[6] > 0.01);
    CHECK(means[2] == Approx(0.0).margin(0));
    CHECK(means[8] > means[0] + means[3] + means[4]);
}
