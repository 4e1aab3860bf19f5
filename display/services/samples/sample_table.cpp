#include "display/services/samples/sample_table.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "display/services/samples/path_words.h"

namespace raylex::display {
namespace {

/// What is made of another channel has no values of its own.
std::size_t values_per_row(const ChannelDefinition& channel) {
    return takes_samples(channel) ? static_cast<std::size_t>(component_count(channel.type)) : 0;
}

}  // namespace

SampleTable::SampleTable(std::span<const ChannelDefinition> channels, int max_rows, int max_extra_rows,
                         const SplatSets* sets)
    : sets_(sets != nullptr && sets->size() > 0 ? sets : nullptr),
      shared_(channels.size(), 0),
      channels_(channels.begin(), channels.end()),
      row_capacity_(static_cast<std::size_t>(max_rows) + static_cast<std::size_t>(max_extra_rows)),
      max_rows_(max_rows) {
    std::size_t size = 0;
    for (const ChannelDefinition& channel : channels_) {
        offset_.push_back(size);
        size += row_capacity_ * values_per_row(channel);
        fill_.push_back(channel.style == ChannelStyle::name ? static_cast<double>(channel.miss_value) : 0.0);
    }
    if (sets_ != nullptr) {
        std::copy(sets_->shared().begin(), sets_->shared().end(), shared_.begin());
        place_of_set_.assign(sets_->size(), -1);
        sets_in_use_.reserve(set_chunk);
        set_rows_.resize(row_capacity_);
    }
    values_.resize(size);
    while (row_capacity_ > std::size_t{64} << stripe_shift_) ++stripe_shift_;
    touched_.assign(offset_.size(), 0);
    std::fill_n(touched_.begin(), channels_.size(),
                ~std::uint64_t{0});  // so that clear_rows() fills in the miss values
    row_states_.assign(channels_.size() * row_capacity_, RowState::untouched);
    camera_rows_.resize(static_cast<std::size_t>(max_rows));
    originals_.resize(row_capacity_);
    std::iota(originals_.begin(), originals_.end(), 0);
    depth.resize(row_capacity_);
    is_volume.resize(row_capacity_);
    opacity.resize(row_capacity_);
    surface.resize(row_capacity_);
    valid.resize(row_capacity_);
    invalid_.resize(static_cast<std::size_t>(max_rows));
    invalid_by_channel_.resize(channels_.size());
    invalid_log_.reserve(invalid_samples_kept);
    clear_rows(static_cast<int>(row_capacity_));
}

SampleTable::SampleTable(SampleTable&&) noexcept = default;
SampleTable::~SampleTable() = default;

PathWords& SampleTable::keep_words(const WordAlphabet& alphabet) {
    words_ = std::make_unique<PathWords>(alphabet);
    return *words_;
}

void SampleTable::clear_channel(std::size_t channel, std::size_t values, double fill, std::size_t rows) {
    double* const first = values_.data() + offset_[channel];
    const bool plain = channels_[channel].style == ChannelStyle::name;
    RowState* const states = plain ? row_states_.data() + channel * row_capacity_ : nullptr;
    for (std::uint64_t stripes = std::exchange(touched_[channel], 0); stripes != 0;) {
        // Stripes in a row are cleared as one: a channel that everything is sent to has but one such run.
        const int begin = std::countr_zero(stripes), end = begin + std::countr_one(stripes >> begin);
        stripes = end == 64 ? 0 : stripes & (~std::uint64_t{0} << end);
        const std::size_t from = std::min(static_cast<std::size_t>(begin) << stripe_shift_, rows);
        const std::size_t to = std::min(static_cast<std::size_t>(end) << stripe_shift_, rows);
        if (std::bit_cast<std::uint64_t>(fill) == 0) {  // by the widest stores of the processor that runs
            if (from < to) std::memset(first + from * values, 0, (to - from) * values * sizeof(double));
        } else {
            std::fill(first + from * values, first + to * values, fill);
        }
        if (plain) std::fill(states + from, states + to, RowState::untouched);
    }
}

void SampleTable::clear_rows(int count) {
    const auto rows = static_cast<std::size_t>(count);
    sent_apart_ = 0;
    for (std::size_t channel = 0; channel < channels_.size(); ++channel)
        if (touched_[channel] != 0) clear_channel(channel, values_per_row(channels_[channel]), fill_[channel], rows);
    clear_sets();
}

void SampleTable::clear_sets() {
    if (sets_in_use_.empty()) return;
    for (SetChunk& chunk : set_chunks_)
        for (std::size_t block = 0; block < set_blocks_; ++block)
            for (std::size_t word = 0; word < chunk.masks[block].size(); ++word)
                for (std::uint64_t places = std::exchange(chunk.masks[block][word], 0); places != 0;
                     places &= places - 1)
                    chunk
                        .sums[block * set_stride + 64 * word + static_cast<std::size_t>(std::countr_zero(places))] = {};
    for (const std::uint32_t set : sets_in_use_) place_of_set_[set] = -1;
    sets_in_use_.clear();
}

std::int32_t SampleTable::add_set(std::size_t set) {
    if (sets_in_use_.size() == set_chunk * set_chunks_.size()) {
        const auto blocks = static_cast<std::size_t>(max_rows_);
        set_chunks_.push_back({std::vector<SetSum>(blocks * set_stride), std::vector<SetMask>(blocks)});
    }
    sets_in_use_.push_back(static_cast<std::uint32_t>(set));
    return place_of_set_[set] = static_cast<std::int32_t>(sets_in_use_.size() - 1);
}

/// A camera row is in the block of the row before it, or begins the next one.
void SampleTable::find_set_blocks(std::size_t first_row, std::size_t end_row) {
    if (sets_ == nullptr || first_row == end_row) return;
    const CameraRow* const rows = camera_rows_.data();
    const int bits = sets_->block_bits();
    if (first_row == 0) {
        set_blocks_ = 1;
        set_rows_[first_row] = {0, rows[first_row].filter_weight};
        ++first_row;
    }
    for (std::size_t row = first_row; row < end_row; ++row) {
        const CameraRow &camera = rows[row], &before = rows[row - 1];
        const bool other_pixel = ((camera.pixel_x ^ before.pixel_x) | (camera.pixel_y ^ before.pixel_y)) != 0;
        const bool next_block = (camera.sample ^ before.sample) >> bits != 0;
        set_blocks_ += static_cast<std::uint32_t>(other_pixel | next_block);
        set_rows_[row] = {set_blocks_ - 1, camera.filter_weight};
    }
}

void SampleTable::begin(std::span<const CameraRow> rows) {
    assert(rows.size() <= static_cast<std::size_t>(max_rows_));
    clear_rows(row_count_);
    discarded_ = false;
    if (words_) words_->clear();
    const std::size_t count = std::min(rows.size(), static_cast<std::size_t>(max_rows_));
    camera_row_count_ = row_count_ = static_cast<int>(count);
    std::copy_n(rows.begin(), count, camera_rows_.begin());
    std::iota(originals_.begin(), originals_.begin() + static_cast<std::ptrdiff_t>(count), 0);
    std::fill_n(depth.begin(), count, std::numeric_limits<float>::infinity());
    std::fill_n(is_volume.begin(), count, std::uint8_t{0});
    std::fill_n(opacity.begin(), count, RgbD{});
    std::fill_n(surface.begin(), count, 0);
    std::fill_n(valid.begin(), count, std::uint8_t{1});
    std::fill_n(invalid_.begin(), count, 0u);
    find_set_blocks(0, count);
}

int SampleTable::add_camera_row(const CameraRow& camera) {
    assert(row_count_ == camera_row_count_);
    if (camera_row_count_ == max_rows_) return -1;
    const int row = camera_row_count_++;
    row_count_ = camera_row_count_;
    const auto index = static_cast<std::size_t>(row);
    camera_rows_[index] = camera;
    originals_[index] = row;
    depth[index] = std::numeric_limits<float>::infinity();
    is_volume[index] = 0;
    opacity[index] = RgbD{};
    surface[index] = 0;
    valid[index] = 1;
    invalid_[index] = 0;
    find_set_blocks(index, index + 1);
    return row;
}

void SampleTable::count_invalid(int row, ChannelId channel, const Rgb& value) {
    ++invalid_[static_cast<std::size_t>(original(row))];
    ++invalid_total_;
    if (channel >= 0) count_invalid_of(channel);
    if (invalid_log_.size() == invalid_samples_kept) return;
    const CameraRow& camera = camera_row(row);
    invalid_log_.push_back({camera.pixel_x, camera.pixel_y, camera.sample, value, channel});
}

void SampleTable::discard() {
    clear_rows(row_count_);
    if (words_) words_->clear();
    discarded_ = true;
}

int SampleTable::add_row(int original) {
    if (static_cast<std::size_t>(row_count_) == row_capacity_) return -1;
    const int row = row_count_++;
    const auto index = static_cast<std::size_t>(row);
    originals_[index] = originals_[static_cast<std::size_t>(original)];
    depth[index] = std::numeric_limits<float>::infinity();
    is_volume[index] = 0;
    opacity[index] = RgbD{};
    surface[index] = 0;
    valid[index] = 1;
    if (sets_ != nullptr) set_rows_[index] = set_rows_[static_cast<std::size_t>(originals_[index])];
    return row;
}

}  // namespace raylex::display
