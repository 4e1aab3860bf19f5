#include "display/services/samples/sample_table.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "display/services/samples/batch_path_strings.h"

namespace raylex::display {
namespace {

/// Outputs of other channels have no values of their own.
std::size_t values_per_row(const ChannelDefinition& channel) {
    return takes_samples(channel) ? static_cast<std::size_t>(component_count(channel.type)) : 0;
}

}  // namespace

SampleTable::SampleTable(std::span<const ChannelDefinition> channels, int max_rows, const SplatSets* sets)
    : sets_(sets != nullptr && sets->size() > 0 ? sets : nullptr),
      shared_(channels.size(), 0),
      channels_(channels.begin(), channels.end()) {
    for (const ChannelDefinition& channel : channels_)
        fill_.push_back(channel.style == ChannelStyle::name ? static_cast<double>(channel.miss_value) : 0.0);
    if (sets_ != nullptr) {
        std::copy(sets_->shared().begin(), sets_->shared().end(), shared_.begin());
        place_of_set_.assign(sets_->size(), -1);
        sets_in_use_.reserve(set_chunk);
    }
    touched_.assign(channels_.size(), 0);
    ever_touched_.assign(channels_.size(), 0);
    offset_.assign(channels_.size(), 0);
    counts_.invalid_by_channel.resize(channels_.size());
    counts_.invalid_log.reserve(invalid_samples_kept);
    counts_.refusals.resize(channels_.size() + 1);
    counts_before_ = counts_;
    reserve_camera_rows(max_rows);
}

SampleTable::SampleTable(SampleTable&&) noexcept = default;
SampleTable::~SampleTable() = default;

BatchPathStrings& SampleTable::keep_path_strings(const PathAlphabet& alphabet) {
    words_ = std::make_unique<BatchPathStrings>(alphabet);
    return *words_;
}

void SampleTable::reserve_camera_rows(int max_rows) {
    const auto rows = static_cast<std::size_t>(max_rows);
    reserve_rows(rows);
    max_rows_ = max_rows;
    camera_rows_.resize(rows);
    extra_rows_.resize(rows);
    reported.resize(rows);
    invalid_.resize(rows);
    for (SetChunk& chunk : set_chunks_) {
        chunk.sums.resize(rows * set_stride);
        chunk.masks.resize(rows);
    }
}

/// Values are stored by channel, so the rows of each channel move. New rows have the channel's miss value.
void SampleTable::reserve_rows(std::size_t capacity) {
    if (capacity <= row_capacity_) return;
    std::size_t size = 0;
    for (const ChannelDefinition& channel : channels_) size += capacity * values_per_row(channel);
    std::vector<double> values(size);
    std::vector<RowState> states(channels_.size() * capacity, RowState::untouched);
    std::size_t to = 0;
    for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
        const std::size_t per_row = values_per_row(channels_[channel]), held = row_capacity_ * per_row;
        std::copy_n(values_.data() + offset_[channel], held, values.data() + to);
        std::fill_n(values.data() + to + held, capacity * per_row - held, fill_[channel]);
        std::copy_n(row_states_.data() + channel * row_capacity_, row_capacity_, states.data() + channel * capacity);
        offset_[channel] = std::exchange(to, to + capacity * per_row);
    }
    values_ = std::move(values);
    row_states_ = std::move(states);
    for (; capacity > std::size_t{64} << stripe_shift_; ++stripe_shift_)
        for (std::uint64_t& stripes : touched_) {
            std::uint64_t wider = 0;  // a stripe with twice the rows is touched if one of its halves is
            for (; stripes != 0; stripes &= stripes - 1) wider |= std::uint64_t{1} << std::countr_zero(stripes) / 2;
            stripes = wider;
        }
    originals_.resize(capacity);
    depth.resize(capacity);
    is_volume.resize(capacity);
    opacity.resize(capacity);
    surface.resize(capacity);
    valid.resize(capacity);
    if (sets_ != nullptr) set_rows_.resize(capacity);
    row_capacity_ = capacity;
}

void SampleTable::clear_row(std::size_t row) {
    depth[row] = std::numeric_limits<float>::infinity();
    is_volume[row] = 0;
    opacity[row] = RgbD{};
    surface[row] = 0;
    valid[row] = 1;
}

void SampleTable::clear_channel(std::size_t channel, std::size_t values, double fill, std::size_t rows) {
    double* const first = values_.data() + offset_[channel];
    const bool plain = channels_[channel].style == ChannelStyle::name;
    RowState* const states = plain ? row_states_.data() + channel * row_capacity_ : nullptr;
    if (!discarded_) ever_touched_[channel] = 1;
    for (std::uint64_t stripes = std::exchange(touched_[channel], 0); stripes != 0;) {
        // Adjacent stripes are cleared together: a channel that gets all samples has a single run of stripes.
        const int begin = std::countr_zero(stripes), end = begin + std::countr_one(stripes >> begin);
        stripes = end == 64 ? 0 : stripes & (~std::uint64_t{0} << end);
        const std::size_t from = std::min(static_cast<std::size_t>(begin) << stripe_shift_, rows);
        const std::size_t to = std::min(static_cast<std::size_t>(end) << stripe_shift_, rows);
        if (std::bit_cast<std::uint64_t>(fill) == 0) {  // lets the processor use its widest stores
            if (from < to) std::memset(first + from * values, 0, (to - from) * values * sizeof(double));
        } else {
            std::fill(first + from * values, first + to * values, fill);
        }
        if (plain) std::fill(states + from, states + to, RowState::untouched);
    }
}

void SampleTable::clear_rows(int count) {
    const auto rows = static_cast<std::size_t>(count);
    sent_separately_ = 0;
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

/// A camera row is in the block of the previous row, or starts the next block.
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
    discarded_ = handed_on_ = false;
    if (std::exchange(counts_changed_, false)) counts_before_ = counts_;
    if (words_) words_->clear();
    if (row_count_ > camera_row_count_) std::fill_n(extra_rows_.begin(), camera_row_count_, ExtraRowsOfRay());
    const std::size_t count = std::min(rows.size(), static_cast<std::size_t>(max_rows_));
    camera_row_count_ = row_count_ = static_cast<int>(count);
    std::copy_n(rows.begin(), count, camera_rows_.begin());
    std::iota(originals_.begin(), originals_.begin() + static_cast<std::ptrdiff_t>(count), 0);
    std::fill_n(depth.begin(), count, std::numeric_limits<float>::infinity());
    std::fill_n(is_volume.begin(), count, std::uint8_t{0});
    std::fill_n(opacity.begin(), count, RgbD{});
    std::fill_n(surface.begin(), count, 0);
    std::fill_n(valid.begin(), count, std::uint8_t{1});
    std::fill_n(reported.begin(), count, std::uint8_t{0});
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
    clear_row(index);
    reported[index] = 0;
    invalid_[index] = 0;
    find_set_blocks(index, index + 1);
    return row;
}

/// Returns false in a discarded batch, which is not counted.
bool SampleTable::counts_now() {
    counts_changed_ = true;
    return !discarded_;
}

void SampleTable::count_invalid(int row, ChannelId channel, const Rgb& value) {
    ++invalid_[static_cast<std::size_t>(original(row))];
    if (!counts_now()) return;
    ++counts_.invalid;
    if (channel >= 0) count_invalid_of(channel);
    if (counts_.invalid_log.size() == invalid_samples_kept) return;
    const CameraRow& camera = camera_row(row);
    counts_.invalid_log.push_back({camera.pixel_x, camera.pixel_y, camera.sample, value, channel});
}

void SampleTable::count_invalid_of(ChannelId channel) {
    if (counts_now()) ++counts_.invalid_by_channel[static_cast<std::size_t>(channel)];
}

void SampleTable::count_refusal(ChannelId channel, Refusal reason, std::uint64_t count) {
    const bool known = channel >= 0 && channel < channel_count();
    if (counts_now())
        counts_.refusals[known ? static_cast<std::size_t>(channel) : channels_.size()]
            .by[static_cast<std::size_t>(reason)] += count;
}

bool SampleTable::discard() {
    if (handed_on_) return false;
    discarded_ = true;
    clear_rows(row_count_);
    if (words_) words_->clear();
    counts_ = counts_before_;
    return true;
}

int SampleTable::add_row(int row) {
    const std::int32_t camera = original(row);
    ExtraRowsOfRay& of_ray = extra_rows_[static_cast<std::size_t>(camera)];
    if (of_ray.count == most_extra_rows) return -1;
    const auto index = static_cast<std::size_t>(row_count_);
    // Four rows per camera ray are enough for most scenes; then the capacity doubles.
    if (index == row_capacity_)
        reserve_rows(std::max(2 * row_capacity_, row_capacity_ + 4 * static_cast<std::size_t>(max_rows_)));
    ++row_count_;
    ++of_ray.count;
    of_ray.last = static_cast<std::int32_t>(index);
    originals_[index] = camera;
    clear_row(index);
    if (sets_ != nullptr) set_rows_[index] = set_rows_[static_cast<std::size_t>(camera)];
    return of_ray.last;
}

}  // namespace raylex::display
