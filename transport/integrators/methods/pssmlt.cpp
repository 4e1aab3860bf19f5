#include "transport/integrators/methods/pssmlt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "transport/cameras/camera.h"
#include "transport/integrators/methods/pssmlt_state.h"
#include "transport/math/sampling.h"
#include "transport/paths/subpaths/camera_subpaths.h"

namespace raylex::transport {
namespace {

// What streams of draws are for, and what a chain chooses by its own numbers.
enum Purpose : std::uint64_t { of_bootstrap = 1, of_chain = 2, of_start = 3 };
enum Choice : std::uint32_t { accept_choice, large_choice };

}  // namespace

std::uint64_t Pssmlt::stream(std::uint64_t purpose, std::uint64_t number) const {
    return mix_bits(mix_bits(context_.services.seed + purpose * 0x9e3779b97f4a7c15ull) ^ number);
}

std::size_t Pssmlt::bootstrap_paths_of_tile() const {
    const std::size_t tiles = groups_.size();
    return (parameters_.bootstrap_samples + tiles - 1) / tiles;
}

void Pssmlt::begin_path(PssmltThread& thread, std::size_t row, PrimarySamples& numbers, std::uint64_t number) const {
    thread.samplers[row] = PixelSampler(numbers);
    const PixelSampler& sampler = thread.samplers[row];
    const Vec2 u = sampler.get_2d(filter_dimension);
    display::CameraRow& camera = thread.rows[row];
    camera = display::CameraRow();
    camera.screen_x = to_float(left_ + across_ * u.x);
    camera.screen_y = to_float(top_ + down_ * u.y);
    camera.pixel_x = static_cast<std::int32_t>(std::floor(camera.screen_x));
    camera.pixel_y = static_cast<std::int32_t>(std::floor(camera.screen_y));
    camera.sample = (number << 32) + numbers.mutations();
    const Real time = sample_time(context_.scene, sampler);
    camera.shutter_time = to_float(time);
    thread.rays[row] = context_.view.camera->generate(
        {camera.screen_x, camera.screen_y,
         context_.view.camera->has_lens() ? sampler.get_2d(lens_dimension) : Vec2{0, 0}, time});
    if (context_.scene.materials->filters_images())  // a chain stands for many samples
        thread.rays[row].cone = cone_of_sample(thread.rays[row].cone, ~std::uint64_t{0});
}

bool Pssmlt::trace(PssmltThread& thread, std::size_t count, ThreadServices& services) const {
    thread.table.begin({thread.rows.data(), count});
    if (parameters_.bidirectional) thread.proposal_splats.begin({thread.rows.data(), count});
    ThreadServices own{thread.display, thread.lpe, &thread.raster, services.leave};
    path_->integrate({{thread.rays.data(), count}, {thread.samplers.data(), count}, {thread.rows.data(), count}},
                     *thread.path, own);
    services.left = own.left;
    if (own.left) {
        thread.raster.discard();
        return false;
    }
    thread.raster.finish();
    return true;
}

void ProposalSplats::begin(std::span<const display::CameraRow> proposals) {
    proposal_of_.clear();
    for (std::size_t i = 0; i < proposals.size(); ++i) proposal_of_[proposals[i].sample] = i;
    splats_.resize(std::max(splats_.size(), proposals.size()));
    for (StateSplats& each : splats_) each.clear();
    contributions_.assign(proposals.size(), 0);
    refused_.assign(proposals.size(), 0);
}

void ProposalSplats::take(display::SampleTable& table) {
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const display::CameraRow& where = table.camera_row(row);
        const std::size_t proposal = proposal_of_.at(where.sample);
        refused_[proposal] += table.invalid_count(row);
        StateSplats& splats = splats_[proposal];
        splats.positions.push_back({where.screen_x, where.screen_y});
        const std::size_t at = 3 * static_cast<std::size_t>(row);
        for (const display::ChannelId id : channels_)
            splats.values.insert(splats.values.end(), table.values(id) + at, table.values(id) + at + 3);
        double sum = 0;
        for (const display::ChannelId id : target_)
            for (std::size_t c = 0; c < 3; ++c) sum += std::abs(table.values(id)[at + c]);
        contributions_[proposal] += sum / 3;
    }
}

double Pssmlt::scalar_contribution(const PssmltThread& thread, std::size_t row) const {
    double sum = 0;
    for (const display::ChannelId id : target_) {
        if (!thread.table.touched(id)) continue;
        const double* values = thread.table.values(id) + 3 * row;
        sum += std::abs(values[0]) + std::abs(values[1]) + std::abs(values[2]);
    }
    // What lands at a position drawn over all of the raster counts area_share_ times; splats land where they do.
    return sum / 3 + thread.proposal_splats.scalar_contribution(row) / area_share_;
}

void Pssmlt::copy_splats(const PssmltThread& thread, std::size_t row, StateSplats& splats) const {
    splats.positions.assign(1, {thread.rows[row].screen_x, thread.rows[row].screen_y});
    splats.values.resize(3 * splatted_.size());
    for (std::size_t i = 0; i < splatted_.size(); ++i)
        std::copy_n(thread.table.values(splatted_[i]) + 3 * row, 3, &splats.values[3 * i]);
    const StateSplats& further = thread.proposal_splats.of(row);
    splats.positions.insert(splats.positions.end(), further.positions.begin(), further.positions.end());
    splats.values.insert(splats.values.end(), further.values.begin(), further.values.end());
}

void Pssmlt::splat(display::RasterSplats& raster, display::CameraRow where, double weight,
                   const StateSplats& splats) const {
    for (std::size_t i = 0; i < splats.positions.size(); ++i) {
        where.screen_x = to_float(splats.positions[i].x);
        where.screen_y = to_float(splats.positions[i].y);
        raster.add(where, i == 0 ? weight * area_share_ : weight, splatted_, &splats.values[3 * splatted_.size() * i]);
    }
}

void Pssmlt::bootstrap(ChainGroup& group, std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const {
    const std::size_t wanted = bootstrap_paths_of_tile(), room = thread.rows.size();
    while (group.bootstrap.size() < wanted) {
        const std::size_t first = group.bootstrap.size(), count = std::min(room, wanted - first);
        for (std::size_t i = 0; i < count; ++i) {
            PrimarySamples& numbers = thread.bootstrap_numbers[i];
            numbers.restart(stream(of_bootstrap, tile * wanted + first + i));
            numbers.propose(true, parameters_.sigma);
            begin_path(thread, i, numbers, tile * wanted + first + i);
        }
        if (!trace(thread, count, services)) return;
        for (std::size_t i = 0; i < count; ++i) group.bootstrap.push_back(scalar_contribution(thread, i));
    }
}

void Pssmlt::end_startup() {
    if (!chains_) return;
    // The running sums over all bootstrap paths, in their order.
    std::vector<double> below;
    below.reserve(groups_.size() * bootstrap_paths_of_tile());
    double sum = 0;
    for (ChainGroup& group : groups_) {
        for (const double f : group.bootstrap) {
            sum += f;
            below.push_back(sum);
        }
        group.bootstrap = std::vector<double>();
    }
    mean_ = bootstrap_mean_ = sum / static_cast<double>(below.size());
    if (!(sum > 0)) return;  // nothing is lit: no chain has where to begin
    std::size_t chains = 0;
    for (const ChainGroup& group : groups_) chains += group.chains.size();
    std::size_t number = 0;
    for (ChainGroup& group : groups_)
        for (MarkovChain& chain : group.chains) {
            // Stratified over the chains: each begins in its own share of the sum.
            const double u = static_cast<double>(unit_float(mix_bits(stream(of_start, number))));
            const double target = sum * ((static_cast<double>(number) + u) / static_cast<double>(chains));
            const auto at = std::upper_bound(below.begin(), below.end(), target);
            const auto index = std::min<std::size_t>(static_cast<std::size_t>(at - below.begin()), below.size() - 1);
            chain.numbers.restart(stream(of_bootstrap, index));
            ++number;
        }
}

void Pssmlt::start(ChainGroup& group, std::uint32_t tile, PssmltThread& thread, ThreadServices& services) const {
    group.started = true;
    for (std::size_t first = 0; first < group.chains.size(); first += thread.rows.size()) {
        const std::size_t count = std::min(thread.rows.size(), group.chains.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            PrimarySamples& numbers = group.chains[first + i].numbers;
            numbers.propose(true, parameters_.sigma);
            begin_path(thread, i, numbers, tile * group.chains.size() + first + i);
        }
        if (!trace(thread, count, services)) return;
        for (std::size_t i = 0; i < count; ++i) {
            MarkovChain& chain = group.chains[first + i];
            chain.numbers.accept();
            chain.numbers.switch_stream(stream(of_chain, (std::uint64_t{tile} << 32) + first + i));
            chain.f = scalar_contribution(thread, i);
            copy_splats(thread, i, chain.splats);
        }
    }
}

void Pssmlt::step(ChainGroup& group, std::uint32_t tile, std::size_t count, PssmltThread& thread,
                  ThreadServices& services) const {
    const auto chain_of = [&](std::size_t i) { return (group.next + i) % group.chains.size(); };
    for (std::size_t i = 0; i < count; ++i) {
        MarkovChain& chain = group.chains[chain_of(i)];
        chain.large = chain.numbers.choose(large_choice) < parameters_.large_step_probability;
        chain.numbers.propose(chain.large, parameters_.sigma);
        begin_path(thread, i, chain.numbers, tile * group.chains.size() + chain_of(i));
    }
    if (!trace(thread, count, services)) return;
    const double p = static_cast<double>(parameters_.large_step_probability);
    for (std::size_t i = 0; i < count; ++i) {
        MarkovChain& chain = group.chains[chain_of(i)];
        const double f = scalar_contribution(thread, i);
        for (std::uint32_t refused =
                 thread.table.invalid_count(static_cast<int>(i)) + thread.proposal_splats.refused(i);
             refused > 0; --refused) {
            // Refused already and in none of the values; counted and logged (Law 6) with the splats, which the engine
            // looks at.
            const display::Tracker tracker =
                services.raster->begin(thread.rows[i].screen_x, thread.rows[i].screen_y, thread.rows[i]);
            services.raster->lpe().contribute(raylex::Rgb(std::numeric_limits<float>::quiet_NaN()), {}, tracker);
        }
        if (chain.large) {
            group.large_sum += f;
            ++group.large_count;
        }
        const double a = chain.f > 0 ? std::min(1.0, f / chain.f) : 1.0;
        const double proposal_weight = (a + (chain.large ? 1 : 0)) / (f / mean_ + p);
        chain.weight += (1 - a) / (chain.f / mean_ + p);
        const bool accepted = static_cast<double>(chain.numbers.choose(accept_choice)) < a;
        if (accepted) {
            if (chain.weight > 0) splat(*services.raster, thread.rows[i], chain.weight, chain.splats);
            chain.numbers.accept();
            chain.f = f;
            chain.weight = proposal_weight;
            copy_splats(thread, i, chain.splats);
        } else {
            chain.numbers.reject();
            if (!(proposal_weight > 0)) continue;  // else large steps bring what the target takes nothing of
            copy_splats(thread, i, thread.proposal);
            splat(*services.raster, thread.rows[i], proposal_weight, thread.proposal);
        }
    }
    group.next = chain_of(count);
}

void Pssmlt::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PssmltThread&>(state);
    ChainGroup& group = groups_[batch.tile];
    if (batch.startup) {
        services.display.discard_iteration();
        if (chains_) bootstrap(group, batch.tile, thread, services);
        thread.take_counters();
        return;
    }
    camera_->integrate(batch, *thread.camera, services);
    if (!chains_ && parameters_.max_depth > 0 && context_.events->any())
        thread.counters.leave_out_paths(batch.rays.size());
    if (mean_ > 0) {
        if (!group.started && !services.left) start(group, batch.tile, thread, services);
        for (std::size_t left = batch.rays.size(); left > 0 && !services.left;) {
            const std::size_t count = std::min({left, group.chains.size(), thread.rows.size()});
            step(group, batch.tile, count, thread, services);
            left -= count;
        }
        if (services.left) return;
        display::CameraRow where;
        for (MarkovChain& chain : group.chains) {  // whoever looks at the image finds every step in it
            if (!(chain.weight > 0)) continue;
            splat(*services.raster, where, chain.weight, chain.splats);
            chain.weight = 0;
        }
    }
    thread.take_counters();
}

void Pssmlt::end_iteration(std::uint64_t /*iteration*/, std::span<IntegratorThread* const> /*threads*/) {
    double count = static_cast<double>(bootstrap_paths_of_tile() * groups_.size()), sum = bootstrap_mean_ * count;
    for (const ChainGroup& group : groups_) {
        sum += group.large_sum;
        count += static_cast<double>(group.large_count);
    }
    mean_ = sum / count;
}

}  // namespace raylex::transport
