#include "display/services/display_services.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace raylex::display {
namespace {

using RowState = SampleTable::RowState;

bool holds_triples(const ChannelDefinition& channel) {
    return takes_samples(channel) && component_count(channel.type) == 3;
}

bool holds(const ChannelDefinition& channel, ChannelType type) {
    return takes_samples(channel) && channel.type == type;
}

}  // namespace

DisplayServices::DisplayServices(SampleTable& table) : table_(table) {
    for (int i = 0; i < table.channel_count(); ++i) {
        const ChannelDefinition& definition = table.channel(i);
        channels_.push_back({i, definition.style, definition.type, definition.name});
    }
    refused_.assign(channels_.size() + 1, 0);
}

bool DisplayServices::accept(ChannelId id, int row, bool fits) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (known && fits && row >= 0 && row < table_.row_count()) return true;
    ++refused_[known ? static_cast<std::size_t>(id) : channels_.size()];
    return false;
}

bool DisplayServices::accept_row(int row, bool fits) {
    if (fits && row >= 0 && row < table_.row_count()) return true;
    ++refused_[channels_.size()];
    return false;
}

/// Where the values of an accepted (id, row) stand, ready to be added to (splatted) or replaced (written).
double* DisplayServices::entry(ChannelId id, int row, RowState state) {
    const int components = component_count(table_.channel(id).type);
    double* values = table_.values(id) + static_cast<std::size_t>(row) * static_cast<std::size_t>(components);
    table_.touch(id);
    if (table_.channel(id).style == ChannelStyle::expression) return values;
    // The first splat into a row replaces the miss value, which may be infinite.
    if (state == RowState::splatted && table_.row_state(id, row) == RowState::untouched && table_.fill_value(id) != 0)
        std::fill_n(values, components, 0.0);
    if (state == RowState::written || table_.row_state(id, row) == RowState::untouched)
        table_.set_row_state(id, row, state);
    return values;
}

bool DisplayServices::splat(ChannelId id, int row, float value) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (!accept(id, row, known && holds(table_.channel(id), ChannelType::real) && std::isfinite(value))) return false;
    *entry(id, row, RowState::splatted) += static_cast<double>(value);
    return true;
}

bool DisplayServices::splat(ChannelId id, int row, const Rgb& value) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (!accept(id, row, known && holds_triples(table_.channel(id)) && is_finite(value))) return false;
    double* values = entry(id, row, RowState::splatted);
    for (int c = 0; c < 3; ++c) values[c] += static_cast<double>(value[c]);
    return true;
}

bool DisplayServices::splat_multi(std::span<const ChannelId> ids, int row, float value) {
    bool all = true;
    for (const ChannelId id : ids) all &= splat(id, row, value);
    return all;
}

bool DisplayServices::splat_multi(std::span<const ChannelId> ids, int row, const Rgb& value) {
    bool all = true;
    for (const ChannelId id : ids) all &= splat(id, row, value);
    return all;
}

bool DisplayServices::write(ChannelId id, int row, float value) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (!accept(id, row, known && holds(table_.channel(id), ChannelType::real) && std::isfinite(value))) return false;
    *entry(id, row, RowState::written) = static_cast<double>(value);
    return true;
}

bool DisplayServices::write(ChannelId id, int row, const Rgb& value) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (!accept(id, row, known && holds_triples(table_.channel(id)) && is_finite(value))) return false;
    double* values = entry(id, row, RowState::written);
    for (int c = 0; c < 3; ++c) values[c] = static_cast<double>(value[c]);
    return true;
}

bool DisplayServices::write(ChannelId id, int row, std::int32_t value) {
    const bool known = id >= 0 && id < table_.channel_count();
    if (!accept(id, row, known && holds(table_.channel(id), ChannelType::integer))) return false;
    *entry(id, row, RowState::written) = static_cast<double>(value);
    return true;
}

/// The checks of the channel once, those of rows and values for each.
template <class Value>
bool DisplayServices::write_batch(ChannelId id, std::span<const std::int32_t> rows, std::span<const Value> values,
                                  bool fits) {
    const std::size_t count = std::min(rows.size(), values.size());
    if (!fits) {
        const bool known = id >= 0 && id < table_.channel_count();
        refused_[known ? static_cast<std::size_t>(id) : channels_.size()] += count;
        return false;
    }
    if (count == 0) return true;
    double* const to = table_.values(id);
    const auto row_count = static_cast<std::uint32_t>(table_.row_count());
    const bool plain = table_.channel(id).style != ChannelStyle::expression;
    table_.touch(id);
    std::uint64_t refused = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::size_t>(static_cast<std::uint32_t>(rows[i]));
        const Value& value = values[i];
        bool good = row < row_count;
        if constexpr (std::is_same_v<Value, Rgb>) good = good && is_finite(value);
        else if constexpr (std::is_same_v<Value, float>) good = good && std::isfinite(value);
        if (!good) {
            ++refused;
            continue;
        }
        if constexpr (std::is_same_v<Value, Rgb>)
            for (std::size_t c = 0; c < 3; ++c) to[3 * row + c] = static_cast<double>(value[static_cast<int>(c)]);
        else to[row] = static_cast<double>(value);
        if (plain) table_.set_row_state(id, static_cast<int>(row), RowState::written);
    }
    refused_[static_cast<std::size_t>(id)] += refused;
    return refused == 0;
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const float> values) {
    const bool known = id >= 0 && id < table_.channel_count();
    return write_batch(id, rows, values, known && holds(table_.channel(id), ChannelType::real));
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const Rgb> values) {
    const bool known = id >= 0 && id < table_.channel_count();
    return write_batch(id, rows, values, known && holds_triples(table_.channel(id)));
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const std::int32_t> values) {
    const bool known = id >= 0 && id < table_.channel_count();
    return write_batch(id, rows, values, known && holds(table_.channel(id), ChannelType::integer));
}

bool DisplayServices::write_distance(int row, float distance, bool is_volume) {
    if (!accept_row(row, !std::isnan(distance))) return false;
    table_.depth[static_cast<std::size_t>(row)] = distance;
    table_.is_volume[static_cast<std::size_t>(row)] = is_volume ? 1 : 0;
    return true;
}

bool DisplayServices::write_opacity(int row, const Rgb& opacity) {
    if (!accept_row(row, is_finite(opacity))) return false;
    table_.opacity[static_cast<std::size_t>(row)] = RgbD(opacity);
    return true;
}

bool DisplayServices::splat_opacity(int row, const Rgb& opacity) {
    if (!accept_row(row, is_finite(opacity))) return false;
    table_.opacity[static_cast<std::size_t>(row)] += RgbD(opacity);
    return true;
}

bool DisplayServices::write_surface(int row, std::int32_t surface) {
    if (!accept_row(row, surface >= 0)) return false;
    table_.surface[static_cast<std::size_t>(row)] = surface;
    return true;
}

int DisplayServices::add_sample(int row, const ExtraSample& sample) {
    if (!accept_row(row, !std::isnan(sample.depth) && is_finite(sample.opacity) && sample.surface >= 0)) return -1;
    const int added = table_.add_row(row);
    if (added < 0) {
        ++refused_.back();
        return -1;
    }
    const auto index = static_cast<std::size_t>(added);
    table_.depth[index] = sample.depth;
    table_.opacity[index] = sample.opacity;
    table_.is_volume[index] = sample.is_volume ? 1 : 0;
    table_.surface[index] = sample.surface;
    return added;
}

void DisplayServices::discard_iteration() {
    table_.discard();
}

}  // namespace raylex::display
