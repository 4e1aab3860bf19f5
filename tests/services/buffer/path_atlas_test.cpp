// The content of a path atlas per word, and the merging of words within its budget.
#include "display/buffer/sinks/path_atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "display/services/samples/batch_path_strings.h"
#include "lpe/match.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::Random;

constexpr int atlas_width = 16, atlas_height = 8, batch_rows = 16;
constexpr std::size_t atlas_pixels = std::size_t{atlas_width} * atlas_height;

/// Adds paths, given by the letters of their events, to an atlas.
class Fixture {
  public:
    explicit Fixture(std::uint64_t budget)
        : setup_(test::build_setup(channels_, 0)), atlas_([&] {
              PathAtlas::Settings settings;
              settings.width = atlas_width;
              settings.height = atlas_height;
              settings.budget = budget;
              return settings;
          }()) {
        auto events = lpe::parse_events("R,D R,G R,S T,D T,S V,- L,- B,-");
        REQUIRE(events);
        for (std::size_t i = 0; i < events->size(); ++i) (*events)[i].labels.resize(i < 6 ? 2 : 1);
        auto alphabet = PathAlphabet::build(*events, {});
        REQUIRE(alphabet);
        REQUIRE(setup_.keep_path_strings(*std::move(alphabet)));
        table_.emplace(channels_, batch_rows);
        services_.emplace(setup_, *table_, 1);
        const test::Classes classes(setup_);
        class_of_ = {{'D', classes.diffuse},         {'G', classes.glossy},           {'S', classes.singular},
                     {'d', classes.diffuse_through}, {'s', classes.singular_through}, {'V', classes.volume},
                     {'L', classes.light},           {'B', classes.background}};
    }

    struct Path {
        int sample = 0;  ///< index in the batch
        std::string word;
        Rgb light;
    };
    /// Adds one batch: samples [first, first + 16) of a pixel.
    void add(std::size_t pixel, std::uint64_t first, const std::vector<Path>& paths) {
        const int x = static_cast<int>(pixel) % atlas_width, y = static_cast<int>(pixel) / atlas_width;
        table_->begin(test::pixel_rows(x, y, first, batch_rows));
        for (const Path& path : paths) {
            Tracker tracker = services_->begin(path.sample);
            for (const char letter : path.word) services_->move(tracker, class_of_.at(letter));
            services_->contribute(path.light, {}, tracker);
        }
        atlas_.accumulate(*table_);
    }
    [[nodiscard]] PathAtlas& atlas() { return atlas_; }

    /// The word in the notation of the added paths, "DGL" or "D*L"; `*` is an open letter.
    [[nodiscard]] std::string text(std::uint32_t word) const {
        std::string text;
        for (const PathStringTree::Letter letter : atlas_.words().letters(word)) {
            char found = '*';
            for (const auto& [name, event] : class_of_)
                if (letter != PathAlphabet::open &&
                    setup_.words()->letter(setup_.words()->column(event_of(name))) == letter)
                    found = name;
            text += found;
        }
        return text;
    }
    [[nodiscard]] std::map<std::string, PathAtlas::Light> path_strings_of(std::size_t pixel) const {
        std::vector<PathAtlas::Light> lights;
        atlas_.resolve(pixel, 0, lights);
        std::map<std::string, PathAtlas::Light> words;
        for (const PathAtlas::Light& light : lights) REQUIRE(words.emplace(text(light.word), light).second);
        return words;
    }

  private:
    static lpe::Event event_of(char name) {
        static const std::map<char, std::string> texts{{'D', "R,D"}, {'G', "R,G"}, {'S', "R,S"}, {'d', "T,D"},
                                                       {'s', "T,S"}, {'V', "V,-"}, {'L', "L,-"}, {'B', "B,-"}};
        lpe::Event event = lpe::parse_events(texts.at(name))->front();
        event.labels.resize(name == 'L' || name == 'B' ? 1 : 2);
        return event;
    }
    std::vector<ChannelDefinition> channels_{test::plain_channel("beauty", ChannelType::rgb)};
    LpeSetup setup_;
    PathAtlas atlas_;
    std::optional<SampleTable> table_;
    std::optional<LpeServices> services_;
    std::map<char, lpe::EventClass> class_of_;
};

/// All numbers have few bits, and pixels have a power of two of samples, so sums and means are exact.
double sum_of(const std::array<double, 3>& rgb) {
    return rgb[0] + rgb[1] + rgb[2];
}

TEST_CASE("light that came once counts like any other: alone, with more of its eighth, and with another eighth",
          "[path_atlas]") {
    Fixture fixture(0);
    fixture.add(3, 0, {{0, "DL", {1, 2, 4}}, {0, "GL", {1, 0, 0}}, {0, "SL", {8, 8, 8}}, {1, "VL", {2, 2, 2}}});
    // Sample 24 of a pixel belongs to eighth 0, too; sample 17 to eighth 1.
    fixture.add(3, 16, {{8, "DL", {1, 1, 1}}, {1, "GL", {0, 1, 0}}, {2, "VL", {1, 0, 0}}, {3, "VL", {0, 0, 1}}});
    const auto words = fixture.path_strings_of(3);
    REQUIRE(words.size() == 4);
    const auto check = [&](const std::string& word, const std::array<double, 3>& rgb,
                           const std::map<std::size_t, double>& eighths) {
        CAPTURE(word);
        const PathAtlas::Light& light = words.at(word);
        for (std::size_t c = 0; c < 3; ++c) CHECK(32 * light.rgb[c] == rgb[c]);
        for (std::size_t k = 0; k < PathAtlas::parts; ++k)
            CHECK(32 * light.eighths[k] == (eighths.count(k) > 0 ? eighths.at(k) : 0));
    };
    check("DL", {2, 3, 5}, {{0, 10}});
    check("GL", {1, 1, 0}, {{0, 1}, {1, 1}});
    check("SL", {8, 8, 8}, {{0, 24}});
    check("VL", {3, 2, 3}, {{1, 6}, {2, 1}, {3, 1}});
    CHECK(fixture.atlas().entry_count() == 4);
    CHECK(fixture.path_strings_of(4).empty());
}

TEST_CASE("light that came once needs half the memory, and the rest when it comes again", "[path_atlas]") {
    Fixture fixture(0);
    fixture.add(0, 0, {{0, "DL", {1, 1, 1}}});
    const std::uint64_t once = fixture.atlas().memory_bytes();
    fixture.add(1, 0, {{0, "DL", {1, 1, 1}}});
    CHECK(fixture.atlas().memory_bytes() == once + 32 + 8 * 8);  // its light and eight slots
    fixture.add(1, 16, {{0, "DL", {1, 1, 1}}});
    CHECK(fixture.atlas().memory_bytes() == once + 64 + 8 * 8);
    fixture.add(1, 32, {{1, "DL", {1, 1, 1}}});
    CHECK(fixture.atlas().memory_bytes() == once + 64 + 128 + 8 * 8);
}

TEST_CASE(
    "an atlas within its budget keeps all light, separates direct from indirect, and keeps first scatterings longest",
    "[path_atlas]") {
    Random random(17);
    const std::string letters = "DGSdsV";
    bool some_whole = false, some_first_lost = false, some_both = false;
    for (const std::uint64_t budget : {40'000u, 60'000u, 90'000u, 120'000u, 200'000u, 400'000u, 4'000'000u}) {
        CAPTURE(budget);
        Fixture fixture(budget);
        std::vector<double> direct(atlas_pixels, 0), indirect(atlas_pixels, 0);
        constexpr int phases = 4;
        bool first_lost_before = false;
        for (int phase = 0; phase < phases; ++phase) {
            for (std::size_t pixel = 0; pixel < atlas_pixels; ++pixel) {
                std::vector<Fixture::Path> paths;
                for (int path = 0; path < 24; ++path) {
                    std::string word;
                    for (int length = random.below(5); length > 0; --length)
                        word += letters[static_cast<std::size_t>(random.below(6))];
                    const double light = 1 + random.below(8);
                    if (word.size() == 1) direct[pixel] += 3 * light;
                    if (word.size() > 1) indirect[pixel] += 3 * light;
                    paths.push_back({random.below(batch_rows), word + (random.below(4) == 0 ? 'B' : 'L'),
                                     Rgb(static_cast<float>(light))});
                }
                fixture.add(pixel, static_cast<std::uint64_t>(phase) * batch_rows, paths);
            }
            fixture.atlas().end_phase();
            bool first_lost = false, second_kept = false;
            for (std::size_t pixel = 0; pixel < atlas_pixels; ++pixel) {
                double found_direct = 0, found_indirect = 0, eighths = 0, all = 0;
                for (const auto& [word, light] : fixture.path_strings_of(pixel)) {
                    const double whole = batch_rows * (phase + 1) * sum_of(light.rgb);
                    if (word.size() == 2) found_direct += whole;  // "DL", "*L"
                    if (word.size() > 2) found_indirect += whole;
                    all += sum_of(light.rgb);
                    for (const double eighth : light.eighths) eighths += eighth;
                    first_lost = first_lost || word.front() == '*';
                    second_kept = second_kept || (word.size() > 2 && word[0] != '*' && word[1] != '*');
                }
                // Phases end after 16, 32, 48 and 64 samples; division by 48 rounds the sums.
                const double bound = phase == 2 ? 64 * 0x1p-52 : 0;
                REQUIRE(std::abs(found_direct - direct[pixel]) <= bound * direct[pixel]);
                REQUIRE(std::abs(found_indirect - indirect[pixel]) <= bound * indirect[pixel]);
                REQUIRE(std::abs(eighths - all) <= bound * all);
            }
            // No word loses its first scattering while others still have a second one to lose.
            CHECK_FALSE((first_lost && !first_lost_before && second_kept));
            first_lost_before = first_lost;
            some_first_lost = some_first_lost || first_lost;
            some_whole = some_whole || fixture.atlas().merged_path_strings() == 0;
            some_both = some_both || (fixture.atlas().merged_path_strings() > 0 && second_kept);
            const bool all_merged = fixture.atlas().words().size() > 0 && first_lost &&
                                    fixture.atlas().entry_count() <= 4 * atlas_pixels * 2;
            CHECK((fixture.atlas().memory_bytes() <= budget || all_merged));
        }
    }
    // The budgets are chosen so that all of these cases occur.
    CHECK(some_whole);
    CHECK(some_both);
    CHECK(some_first_lost);
}

TEST_CASE("dark words are merged first", "[path_atlas]") {
    Fixture fixture(215'000);
    for (std::size_t pixel = 0; pixel < atlas_pixels; ++pixel) {
        std::vector<Fixture::Path> paths;
        for (const char* const word : {"DDL", "DGL", "DSL", "GDL", "GGL", "GSL", "SDL", "SGL"})
            for (int sample = 0; sample < 3; ++sample)
                paths.push_back({sample, word, Rgb(word[0] == 'D' ? 8.0f : word[0] == 'G' ? 1.0f : 4.0f)});
        fixture.add(pixel, 0, paths);
    }
    const std::uint64_t before = fixture.atlas().memory_bytes();
    REQUIRE(before > 215'000);
    fixture.atlas().end_phase();
    const auto words = fixture.path_strings_of(0);
    CAPTURE(words.size());
    CHECK(words.count("DDL") == 1);
    CHECK(words.count("SDL") == 1);
    CHECK(words.count("GDL") == 0);
    CHECK(words.count("G*L") == 1);
    CHECK(16 * words.at("G*L").rgb[0] == 9);
    CHECK(words.size() == 6);
}

}  // namespace
}  // namespace raylex::display
