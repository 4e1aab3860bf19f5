// Values of flags and job keys that one table of settings reads.
#include <catch2/catch.hpp>

#include "support.h"

using namespace raylex::test;

TEST_CASE("an empty value is refused, or is a value, or counts as not given", "[cli][law7]") {
    const SceneFolder folder;
    for (const char* flags : {"--spp", "--threads", "--until-error 1% --spp"})
        check_refused(folder, "render room.pbrt -o out.exr " + std::string(flags) + " ''", {"expected an integer"});
    check_refused(folder, "render room.pbrt -o out.exr --driver exr:file=a.exr --driver ''", {"--driver"});
    const auto has_default_rules = [&](const std::string& by) {
        CHECK(run_raylex(folder, "render room.pbrt --spp 1 -o out.exr --atlas a.atlas.exr" + by).code == 0);
        return folder.read("a.atlas.exr").find("label,lobe,group") != std::string::npos;
    };
    CHECK(has_default_rules(""));
    CHECK_FALSE(has_default_rules(" --atlas-by ''"));
    CHECK(run_raylex(folder, "render room.pbrt --spp 1 --time '' -o out.exr").code == 0);
}

TEST_CASE("a number may have a plus, and a flag without a value refuses one", "[cli][law7]") {
    const SceneFolder folder;
    CHECK(run_raylex(folder, "render room.pbrt --spp +1 --exposure +1 --preview out.png -o out.exr").code == 0);
    check_refused(folder, "render room.pbrt -o more.exr --exposure +-1", {"--exposure", "from -60 to 60"});
    for (const char* flag : {"--no-beauty=false", "--resume=0", "--light-groups=false"}) {
        const std::string text = flag;
        check_refused(folder, "render room.pbrt -o more.exr --aov z " + text, {text.substr(2, text.find('=') - 2)});
    }
}

TEST_CASE("an array of a job holds integers", "[cli][law7]") {
    const SceneFolder folder;
    for (const char* value : {"[64.0, 48.0]", "['64', '48']", "[[], 64, 48]"}) {
        folder.write("job.toml",
                     "[scene]\nfile = 'room.pbrt'\n[render]\nspp = 1\nresolution = " + std::string(value) + "\n");
        check_refused(folder, "render job.toml -o out.exr", {"job.toml:5", "resolution", "[width, height]"});
    }
}
