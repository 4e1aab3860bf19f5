// The display services against a model: random programs of calls, in any order and for any ray, must give the model's
// results, and the same bits for any batch size.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/sinks/ranked_coverage.h"
#include "display/deep/deep_buffer.h"
#include "display/services/samples/display_services.h"
#include "display/services/samples/raster_splats.h"
#include "tests/services/samples/services_model.h"

namespace raylex::services_model {
namespace {

/// Collects splats as they are passed on.
struct Collector final : RasterSink {
    std::vector<ModelSplat> splats;
    void take(SampleTable& table) override {
        for (int row = 0; row < table.camera_row_count(); ++row) {
            const double* v = table.values(0) + 3 * static_cast<std::size_t>(row);
            const CameraRow& camera = table.camera_row(row);
            // A tracker's row without a valid contribution has no light.
            if (!table.touched(0) || (v[0] == 0 && v[1] == 0 && v[2] == 0)) continue;
            splats.push_back({camera.screen_x, camera.screen_y,
                              Rgb(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]))});
        }
    }
};

struct Outcome {
    std::vector<double> values, alpha;  ///< for all channels and pixels
    std::vector<float> deep;            ///< all deep samples
    std::vector<double> flat;           ///< [pixel] of the deep image: alpha, beauty, heat, N
    std::vector<double> coverage;       ///< [pixel][id]
    std::vector<RefusalCounts> refusals;
    std::uint64_t invalid = 0;
    std::vector<ModelSplat> splats;
    std::uint64_t samples = 0;
};

class Services {
  public:
    Services(const Program& program, const std::vector<ChannelDefinition>& list, std::uint64_t order)
        : program_(program),
          random_(order),
          table_(list, rays),
          services_(table_),
          setup_(*LpeSetup::build(list, 0)),
          splats_(setup_, list, 0, LpeServices::Attribution::exact, collector_, table_),
          buffer_({width, height}, list),
          deep_(width, height, list, {0, 1, 4}, {.most_samples = 4096, .tolerance = 0x1p-23}),
          mattes_(width, height, {0, 10, 20, 30, 40, 50}) {}

    /// Runs batches of `blocks_together` blocks of one iteration; rays alternate in a random order.
    Outcome run(int blocks_together) {
        for (std::size_t iteration = 0; iteration < program_.discarded.size(); ++iteration)
            for (int first = 0; first < pixels; first += blocks_together)
                run_batch(iteration, first, std::min(pixels, first + blocks_together));
        return result();
    }

  private:
    void run_batch(std::size_t iteration, int first_pixel, int end_pixel) {
        std::vector<std::size_t> of;  // [row] its ray
        std::vector<CameraRow> rows;
        for (int pixel = first_pixel; pixel < end_pixel; ++pixel)
            for (int s = 0; s < block; ++s) {
                of.push_back(static_cast<std::size_t>(pixel * samples_per_pixel + s) + iteration * block);
                rows.push_back(program_.rows[of.back()]);
            }
        table_.begin(rows);
        std::vector<std::vector<int>> extra(of.size());
        std::vector<std::size_t> next(of.size()), turns;
        for (std::size_t row = 0; row < of.size(); ++row)
            turns.insert(turns.end(), program_.calls[of[row]].size(), row);
        for (std::size_t i = turns.size(); i > 1; --i)
            std::swap(turns[i - 1], turns[static_cast<std::size_t>(random_.below(static_cast<int>(i)))]);
        const bool discards = program_.discarded[iteration];
        const std::size_t when = program_.discard_first ? 0 : turns.size() / 2;
        for (std::size_t turn = 0; turn <= turns.size(); ++turn) {
            if (discards && turn == when) CHECK(services_.discard_iteration());
            if (turn == turns.size()) break;
            const std::size_t row = turns[turn];
            call(program_.calls[of[row]][next[row]++], static_cast<int>(row), extra[row]);
        }
        splats_.finish();
        buffer_.accumulate(table_);
        deep_.accumulate(table_);
        mattes_.accumulate(table_);
        if (!table_.discarded()) samples_ += of.size();
    }

    void call(const Call& call, int camera_row, std::vector<int>& extra) {
        const int row = call.row == Call::far ? -7
                        : call.row == 0       ? camera_row
                                              : extra[static_cast<std::size_t>(call.row) - 1];
        switch (call.kind) {
            case Kind::splat_float:
                services_.splat(call.channel, row, call.value.r);
                break;
            case Kind::splat_rgb:
                services_.splat(call.channel, row, call.value);
                break;
            case Kind::write_float:
                services_.write(call.channel, row, call.value.r);
                break;
            case Kind::write_rgb:
                services_.write(call.channel, row, call.value);
                break;
            case Kind::write_integer:
                services_.write(call.channel, row, call.integer);
                break;
            case Kind::add:
                if (const int added = services_.add_sample(row, {depth_of(call), RgbD(call.value), call.volume});
                    added >= 0)
                    extra.push_back(added);
                break;
            case Kind::distance:
                services_.write_distance(row, depth_of(call), call.volume);
                break;
            case Kind::opacity:
                services_.write_opacity(row, call.value);
                break;
            case Kind::surface:
                services_.write_surface(row, call.integer);
                break;
            case Kind::raster: {
                const CameraRow& camera = table_.camera_row(camera_row);
                const Tracker tracker = splats_.begin(camera.screen_x, camera.screen_y, camera);
                splats_.lpe().contribute(call.value, {}, tracker);
                break;
            }
        }
    }

    Outcome result() {
        Outcome r;
        for (ChannelId id = 0; id < channels_known; ++id)
            for (const double v : buffer_.resolve(id)) r.values.push_back(v);
        r.alpha = buffer_.resolve_alpha();
        for (int pixel = 0; pixel < pixels; ++pixel) {
            double through = 1;
            std::array<double, 8> flat{};
            for (const DeepSample& s : deep_.resolve(pixel % width, pixel / width)) {
                r.deep.insert(r.deep.end(), {s.z, s.z_back, s.alpha});
                r.deep.insert(r.deep.end(), s.values.begin(), s.values.end());
                for (std::size_t i = 0; i < s.values.size(); ++i)
                    flat[i + 1] += through * static_cast<double>(s.values[i]);
                through *= 1 - static_cast<double>(s.alpha);
            }
            flat[0] = 1 - through;
            r.flat.insert(r.flat.end(), flat.begin(), flat.end());
            std::vector<RankedCoverage::Rank> ranks(6);
            r.coverage.push_back(mattes_.resolve(static_cast<std::size_t>(pixel), ranks));
            std::map<std::uint32_t, double> by_id;
            for (const auto& rank : ranks) by_id[rank.id] += rank.coverage;
            for (const std::uint32_t id : {10u, 20u, 30u, 40u, 50u}) r.coverage.push_back(by_id[id]);
        }
        r.refusals.assign(services_.refusals().begin(), services_.refusals().end());
        r.invalid = table_.invalid_total() + splats_.table().invalid_total();
        r.splats = collector_.splats;
        std::sort(r.splats.begin(), r.splats.end());
        r.samples = samples_;
        return r;
    }

    const Program& program_;
    Random random_;
    SampleTable table_;
    DisplayServices services_;
    LpeSetup setup_;
    Collector collector_;
    RasterSplats splats_;
    FrameBuffer buffer_;
    DeepBuffer deep_;
    RankedCoverage mattes_;
    std::uint64_t samples_ = 0;
};

/// Values are below 4 (sums of 9 calls and 32 samples are below 2^11), so double rounding is below 2^11 2^-53 per term;
/// 2^-38 is enough for the thousand terms of a pixel.
constexpr double rounding = 0x1p-38;

void compare(const Outcome& got, const Model& model, const Program& program,
             const std::vector<ChannelDefinition>& list) {
    std::size_t at = 0;
    double worst = 0;
    for (int channel = 0; channel < channels_known; ++channel) {
        const auto components = static_cast<std::size_t>(component_count(list[static_cast<std::size_t>(channel)].type));
        for (int pixel = 0; pixel < pixels; ++pixel)
            for (std::size_t c = 0; c < components; ++c, ++at) {
                const double expected =
                    pixel_value(model, program, list[static_cast<std::size_t>(channel)], channel, pixel, c);
                if (expected == got.values[at]) continue;  // includes infinite values
                worst = std::max(worst, std::abs(expected - got.values[at]));
                if (std::abs(expected - got.values[at]) <= rounding) continue;
                CAPTURE(channel, pixel, c);
                CHECK(got.values[at] == Approx(expected));
            }
    }
    CHECK(worst <= rounding);
    // Deep samples are floats: a pixel's alpha and light are sums of at most 32 x 9 of them, each rounded to 2^-24 of
    // values below 2^6.
    constexpr double of_floats = 0x1p-24 * 64 * 32 * 9;
    for (int pixel = 0; pixel < pixels; ++pixel) {
        const double* flat = &got.flat[8 * static_cast<std::size_t>(pixel)];
        CHECK(std::abs(flat[0] - got.alpha[static_cast<std::size_t>(pixel)]) <= of_floats);
        std::size_t k = 1;
        for (const int channel : {0, 1, 4})
            for (std::size_t c = 0; c < (channel == 1 ? 1u : 3u); ++c, ++k)
                CHECK(std::abs(flat[k] - pixel_value(model, program, list[static_cast<std::size_t>(channel)], channel,
                                                     pixel, c)) <= of_floats);
        // Mattes round the weight of each row to 2^-32.
        std::map<int, double> covered;
        double weights = 0;
        for (int s = 0; s < samples_per_pixel; ++s) {
            const auto ray = static_cast<std::size_t>(pixel * samples_per_pixel + s);
            if (program.discarded[program.rows[ray].sample / block]) continue;
            double alpha = 0;
            const auto weight = static_cast<double>(program.rows[ray].filter_weight);
            weights += weight;
            for (const auto& [row, coverage] : front_to_back(model.rays[ray], alpha))
                covered[row->surface <= 5 ? row->surface : 0] += weight * coverage;
        }
        for (int surface = 0; surface <= 5; ++surface)
            CHECK(std::abs(got.coverage[6 * static_cast<std::size_t>(pixel) + static_cast<std::size_t>(surface)] -
                           (weights > 0 ? covered[surface] / weights : 0)) <= 0x1p-32 * 32 * 9);
    }
    std::map<std::pair<int, Refusal>, std::uint64_t> refused;
    for (std::size_t channel = 0; channel < got.refusals.size(); ++channel)
        for (int kind = 0; kind < refusal_kinds; ++kind)
            if (const std::uint64_t n = got.refusals[channel].by[static_cast<std::size_t>(kind)]; n > 0)
                refused[{channel < list.size() ? static_cast<int>(channel) : -1, static_cast<Refusal>(kind)}] = n;
    CHECK(refused == model.refusals);
    CHECK(got.invalid == model.invalid);
    CHECK(got.splats == model.splats);
    std::uint64_t kept = 0;
    for (const CameraRow& row : program.rows) kept += program.discarded[row.sample / block] ? 0 : 1;
    CHECK(got.samples == kept);
}

TEST_CASE("a thousand random programs of calls agree with a model of the services", "[services][model][gate]") {
    const std::vector<ChannelDefinition> list = model_channels();
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        CAPTURE(seed);
        const Program program = random_program(seed);
        const Model model = model_of(program, list);
        const Outcome alone = Services(program, list, seed).run(1);
        compare(alone, model, program, list);
        for (const int together : {2, pixels}) {
            const Outcome other = Services(program, list, seed + 7919).run(together);
            REQUIRE(other.values == alone.values);  // bit for bit
            REQUIRE(other.alpha == alone.alpha);
            REQUIRE(other.deep == alone.deep);
            REQUIRE(other.coverage == alone.coverage);
            REQUIRE(other.refusals == alone.refusals);
            REQUIRE(other.invalid == alone.invalid);
            REQUIRE(other.splats == alone.splats);
        }
    }
}

TEST_CASE("a ray has its own limit of extra rows, which neighbours do not affect", "[services]") {
    const std::vector<ChannelDefinition> list{plain_channel("heat", ChannelType::real)};
    SampleTable table(list, 4);
    DisplayServices services(table);
    for (int batch = 0; batch < 2; ++batch) {
        table.begin(test::pixel_rows(0, 0, 0, 4));
        for (int i = 0; i < SampleTable::most_extra_rows; ++i)
            REQUIRE(services.add_sample(1, {static_cast<float>(i), RgbD(0.0)}) >= 0);
        CHECK(services.refusals().back().total() == static_cast<std::uint64_t>(batch));
        const int last = table.last_row_of(1);
        CHECK(services.add_sample(1, {9, RgbD(0.5)}) == last);  // merged and counted
        CHECK(table.opacity[static_cast<std::size_t>(last)] == RgbD(0.5));
        CHECK(services.refusals().back().of(Refusal::no_room) == static_cast<std::uint64_t>(batch) + 1);
        const int other = services.add_sample(2, {1, RgbD(0.25)});
        CHECK(other > last);
        CHECK(services.write(0, other, 3.0f));
        CHECK(table.original(other) == 2);
        CHECK(table.opacity[static_cast<std::size_t>(other)] == RgbD(0.25));
    }
    CHECK(refusal_warnings(list, services.refusals()).front().find("1024 extra rows") != std::string::npos);
}

TEST_CASE("splats of an iteration are kept until its end, up to a memory budget", "[services]") {
    const std::vector<ChannelDefinition> list{expression_channel("beauty", "C.*")};
    const LpeSetup setup = *LpeSetup::build(list, 0);
    SampleTable batch(list, 1);
    DisplayServices services(batch);
    Collector sink;
    RasterSplats splats(setup, list, 0, LpeServices::Attribution::exact, sink, batch);
    const auto send = [&](int count) {
        for (int i = 0; i < count; ++i) splats.lpe().contribute(Rgb(1), {}, splats.begin(1, 1, CameraRow{}));
    };
    batch.begin(test::pixel_rows(0, 0, 0, 1));
    send(50000);
    CHECK(sink.splats.empty());
    CHECK(services.discard_iteration());
    send(5000);
    splats.finish();
    CHECK(sink.splats.empty());
    batch.begin(test::pixel_rows(0, 0, 0, 1));
    send(3000);
    splats.finish();
    CHECK(sink.splats.size() == 3000);
    // Beyond the budget splats are in the image, and the iteration can no longer be discarded: the call is refused.
    batch.begin(test::pixel_rows(0, 0, 0, 1));
    send(1000000);
    CHECK(sink.splats.size() > 3000);
    CHECK_FALSE(services.discard_iteration());
    CHECK(services.refusals().back().of(Refusal::too_late) == 1);
    splats.finish();
    CHECK(sink.splats.size() == 1003000);
}

}  // namespace
}  // namespace raylex::services_model
