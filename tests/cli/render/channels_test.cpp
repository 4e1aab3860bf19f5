// Rules and layers of statistics, by flag and by job.
#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;

namespace {

std::string refusal(const Folder& folder, const std::string& arguments) {
    const Outcome outcome = run_raylex(folder, arguments + " -o refused.exr");
    CAPTURE(arguments, outcome.out);
    CHECK(outcome.code == 2);
    CHECK_FALSE(folder.has("refused.exr"));
    return outcome.err;
}

}  // namespace

TEST_CASE("statistics become consistent layers and do not change the beauty", "[statistics][law2]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder, "render room.pbrt -o plain.exr --lpe direct=CDL").code == 0);
    const Outcome outcome = run_raylex(folder,
                                       "render room.pbrt -o a.exr --lpe direct=CDL --aov Nn --threads 3 "
                                       "--statistics beauty=variance,mse,even,odd --statistics Nn=mse");
    CAPTURE(outcome.err, outcome.out);
    REQUIRE(outcome.code == 0);
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[render]\nthreads = 1\n[channels]\naovs = [\"Nn\"]\n"
                 "[channels.statistics]\nbeauty = [\"variance\", \"mse\", \"even\", \"odd\"]\nNn = [\"mse\"]\n"
                 "[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\nstatistics = [\"odd\"]\n");
    REQUIRE(run_raylex(folder, "render job.toml -o b.exr").code == 0);
    auto plain = read_exr(folder.path("plain.exr")), a = read_exr(folder.path("a.exr")),
         b = read_exr(folder.path("b.exr"));
    REQUIRE((plain && a && b));
    CHECK(b->layer("direct_odd") != nullptr);
    CHECK(a->attributes["statistics/beauty_mse"] == "mse of beauty");
    CHECK(a->attributes["verdict/auto"].starts_with("holds; "));
    double light = 0;
    for (const char* name : {"R", "G", "B"}) {
        const std::vector<float> beauty = plane(*a, "beauty", name);
        CHECK(beauty == plane(*plain, "beauty", name));
        for (const char* layer : {"beauty_variance", "beauty_mse", "beauty_even", "beauty_odd"})
            CHECK(plane(*a, layer, name) == plane(*b, layer, name));  // 3 threads, 1 thread
        const std::vector<float> variance = plane(*a, "beauty_variance", name), mse = plane(*a, "beauty_mse", name),
                                 even = plane(*a, "beauty_even", name), odd = plane(*a, "beauty_odd", name);
        for (std::size_t i = 0; i < beauty.size(); ++i) {
            // 4 samples of weight 1: only rounding to float.
            CHECK(mse[i] == Approx(variance[i] / 4).epsilon(1e-6));
            CHECK((even[i] + odd[i]) / 2 == Approx(beauty[i]).epsilon(1e-6));
            light += static_cast<double>(even[i]);
        }
        CHECK(even != odd);
    }
    CHECK(light > 0);
    CHECK(plane(*a, "Nn_mse", "X") == plane(*b, "Nn_mse", "X"));
    CHECK(contains(refusal(folder, "render room.pbrt --statistics beauty=vairance"), "did you mean 'variance'"));
    CHECK(contains(refusal(folder, "render room.pbrt --statistics beaut=mse"), "did you mean 'beauty'"));
    CHECK(contains(refusal(folder, "render room.pbrt --aov z --statistics z=mse"),
                   "has the rule 'zmin', which has no statistics"));
    CHECK(contains(refusal(folder, "render room.pbrt --statistics mse"), "expected one such as beauty=variance,mse"));
    CHECK(contains(refusal(folder, "render room.pbrt --deep d.exr --statistics beauty=mse --deep-channels beauty_mse"),
                   "cannot be deep"));
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[channels.statistics]\nbeauty = [\"mse\", \"evn\"]\n");
    CHECK(contains(refusal(folder, "render bad.toml"), "bad.toml:4:19"));
}

TEST_CASE("a channel with another rule belongs to no partition", "[statistics]") {
    const SceneFolder folder;
    const Outcome outcome = run_raylex(folder,
                                       "render room.pbrt -o a.exr --lpe all='C.*' --lpe brightest='C.*' "
                                       "--rule brightest=max --aov Nn --rule Nn=zmin");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[channels]\naovs = [\"Nn\"]\nrules = { Nn = \"zmin\" }\n"
                 "[[channel]]\nname = \"brightest\"\nlpe = \"C.*\"\nrule = \"max\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o b.exr").code == 0);
    auto a = read_exr(folder.path("a.exr")), b = read_exr(folder.path("b.exr"));
    REQUIRE((a && b));
    CHECK(a->attributes["rule/brightest"] == "max");
    CHECK(plane(*a, "Nn", "Y") == plane(*b, "Nn", "Y"));
    for (const char* name : {"R", "G", "B"}) {
        const std::vector<float> mean = plane(*a, "all", name), most = plane(*a, "brightest", name);
        CHECK(most == plane(*b, "brightest", name));
        CHECK(most != mean);
        for (std::size_t i = 0; i < mean.size(); ++i) CHECK(most[i] >= mean[i] * (1 - 1e-6f));
    }
    // The nearest sample's normal has unit length; a filtered one need not.
    const std::vector<float> x = plane(*a, "Nn", "X"), y = plane(*a, "Nn", "Y"), z = plane(*a, "Nn", "Z");
    for (std::size_t i = 0; i < x.size(); ++i) {
        const float square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        if (square > 0) CHECK(square == Approx(1).epsilon(1e-5));
    }
    REQUIRE(a->partitions.size() == 1);
    CHECK(a->partitions[0].layers == std::vector<std::string>{"all", "rest"});
    CHECK(contains(refusal(folder, "render room.pbrt --rule beauty=max"), "always uses the pixel filter"));
    CHECK(contains(refusal(folder, "render room.pbrt --aov id --rule id=average"), "integers"));
    CHECK(contains(refusal(folder, "render room.pbrt --lpe direct=CDL --rule rest=max"),
                   "cannot be part of partition 'auto'"));
    CHECK(contains(refusal(folder, "render room.pbrt --partition shipped --rule directDiffuse=zmin"),
                   "cannot be part of partition 'shipped'"));
}

TEST_CASE("channels with user events belong to no split") {
    const SceneFolder folder;
    const Outcome outcome =
        run_raylex(folder, "render room.pbrt --spp 4 -o out.exr --lpe 'albedo=CU2L' --lpe 'direct=C<RD>L'");
    CAPTURE(outcome.out, outcome.err);
    CHECK(outcome.code == 0);
    CHECK(contains(outcome.out, "partition 'auto'"));
    auto image = read_exr(folder.path("out.exr"));
    REQUIRE(image);
    REQUIRE(image->partitions.size() == 1);
    CHECK(image->partitions[0].layers == std::vector<std::string>{"direct", "rest"});
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[output]\nfile = \"o.exr\"\n[[channel]]\nname = \"albedo\"\nlpe = "
                 "\"CU2L\"\n[[partition]]\nname = \"mine\"\nchannels = [\"albedo\"]\nrest = \"other\"\n");
    CHECK(contains(refusal(folder, "render job.toml"),
                   "channel 'albedo' (user events) cannot be part of partition 'mine'"));
}

TEST_CASE("warnings of black layers give the reason and a suggestion, in either dialect", "[gate]") {
    const SceneFolder folder;
    const auto warned = [&](const std::string& lpe, const std::string& why) {
        const Outcome outcome = run_raylex(folder, "render room.pbrt --spp 1 --resolution 4x4 -o black.exr " + lpe);
        CAPTURE(lpe, outcome.err);
        CHECK(contains(outcome.err, why));
    };
    warned("--dialect osl --lpe \"a=C<RD'flor'>L\"", "an object labelled 'flor', and this scene has none");
    warned("--lpe \"a=osl:C<RD'flor'>L\"", "an object labelled 'flor', and this scene has none");
    warned("--lpe \"a=C.*<L.'key'>\"", "[[light_group]] tables give them");
    warned("--lpe a=CD", "it does not end at a light (L, B or O); did you mean 'CDL'?");
    warned("--lpe a=DL", "it does not begin at the camera (C); did you mean 'CDL'?");
    warned("--lpe 'a=lpe:D+'", "did you mean 'lpe:CD+L'?");
    warned("--lpe \"a=C<RD>L'key'\"", "did you mean 'C<RD><L.'key'>'?");
    warned("--lpe 'a=CDL|CSL'", "did you mean '(CDL)|(CSL)'?");
    // An L at the end of a label, with another label far behind it, looks like a light with a very long label.
    warned("--lpe \"a=D'L'" + std::string(60'000, ' ') + "'key'D\"", "it has neither the camera (C) nor a light");
}
