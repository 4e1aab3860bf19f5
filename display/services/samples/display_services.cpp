#include "display/services/samples/display_services.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <type_traits>

namespace raylex::display {
namespace {

using RowState = SampleTable::RowState;

/// Returns whether the rows are consecutive and below `row_count`, so that they can be checked and written together.
bool consecutive(std::span<const std::int32_t> rows, std::uint32_t row_count) {
    const auto first = static_cast<std::uint32_t>(rows.front());
    if (first >= row_count || rows.size() > row_count - first) return false;
    std::uint32_t different = 0, expected = first;
    for (const std::int32_t row : rows) different |= static_cast<std::uint32_t>(row) ^ expected++;
    return different == 0;
}

/// Without a branch, so that the compiler can vectorise it.
[[nodiscard]] std::uint32_t not_finite(float value) {
    constexpr std::uint32_t exponent = 0x7f800000;
    return (std::bit_cast<std::uint32_t>(value) & exponent) == exponent ? 1 : 0;
}

/// Copies to[i] = values[i]. If a value is not finite, returns false and copies nothing.
bool write_all(const float* values, std::size_t count, double* to) {
    std::uint32_t bad = 0;
    for (std::size_t i = 0; i < count; ++i) bad |= not_finite(values[i]);
    if (bad != 0) [[unlikely]]
        return false;
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<double>(values[i]);
    return true;
}
bool write_all(std::span<const float> values, double* to) {
    return write_all(values.data(), values.size(), to);
}
bool write_all(std::span<const Rgb> values, double* to) {
    static_assert(sizeof(Rgb) == 3 * sizeof(float));
    return write_all(&values.front().r, 3 * values.size(), to);
}
/// Copies to[3 i + c] = columns[c][i]. If a value is not finite, returns false and copies nothing.
bool write_all(const DisplayServices::Columns& columns, std::size_t count, double* to) {
    const float *const x = columns[0], *const y = columns[1], *const z = columns[2];
    std::uint32_t bad = 0;
    for (std::size_t i = 0; i < count; ++i) bad |= not_finite(x[i]) | not_finite(y[i]) | not_finite(z[i]);
    if (bad != 0) [[unlikely]]
        return false;
    double* __restrict out = to;
    for (std::size_t i = 0; i < count; ++i) {
        out[3 * i] = static_cast<double>(x[i]);
        out[3 * i + 1] = static_cast<double>(y[i]);
        out[3 * i + 2] = static_cast<double>(z[i]);
    }
    return true;
}
bool write_all(std::span<const std::int32_t> values, double* to) {
    std::copy(values.begin(), values.end(), to);
    return true;
}

}  // namespace

ChannelId find_channel(std::span<const DisplayChannel> channels, std::string_view name) {
    const auto found = std::find_if(channels.begin(), channels.end(), [&](const auto& c) { return c.name == name; });
    return found == channels.end() ? invalid_channel : found->id;
}

/// Compares the last known position of the name first.
ChannelId NamedChannel::id(std::span<const DisplayChannel> channels) const {
    const std::size_t last = last_.load(std::memory_order_relaxed);
    if (last < channels.size() && channels[last].name == name_) return channels[last].id;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        if (channels[i].name != name_) continue;
        last_.store(i, std::memory_order_relaxed);
        return channels[i].id;
    }
    return invalid_channel;
}

DisplayServices::DisplayServices(SampleTable& table) : table_(table) {
    for (int i = 0; i < table.channel_count(); ++i) {
        const ChannelDefinition& definition = table.channel(i);
        if (takes_samples(definition)) channels_.push_back({i, definition.style, definition.type, definition.name});
    }
}

bool DisplayServices::refuse(ChannelId id, Refusal reason, std::uint64_t count) {
    table_.count_refusal(id, reason, count);
    return false;
}

bool DisplayServices::accept(ChannelId id, int row, bool right_type, bool good_value) {
    if (right_type && good_value && row >= 0 && row < table_.row_count()) [[likely]]
        return true;
    if (!known(id) || !takes_samples(table_.channel(id))) return refuse(id, Refusal::unknown_channel);
    if (!right_type) return refuse(id, Refusal::wrong_type);
    return refuse(id, good_value ? Refusal::unknown_row : Refusal::bad_value);
}

bool DisplayServices::accept_row(int row, bool good_value) {
    if (good_value && row >= 0 && row < table_.row_count()) [[likely]]
        return true;
    return refuse(invalid_channel, good_value ? Refusal::unknown_row : Refusal::bad_value);
}

/// Refuses a value that is not finite, for a valid (id, row).
bool DisplayServices::refuse_value(ChannelId id, int row, const Rgb& value) {
    table_.count_invalid(row, id, value);
    return refuse(id, Refusal::bad_value);
}

/// Refuses a distance or an opacity that is not finite, for a valid row.
bool DisplayServices::refuse_row_value(int row, const Rgb& value) {
    table_.count_invalid(row, invalid_channel, value);
    return refuse(invalid_channel, Refusal::bad_value);
}

/// The values of a valid (id, row), ready to be added to (splatted) or replaced (written).
double* DisplayServices::entry(ChannelId id, int row, RowState state) {
    const int components = component_count(table_.channel(id).type);
    double* values = table_.raw_values(id) + static_cast<std::size_t>(row) * static_cast<std::size_t>(components);
    table_.touch(id, row);
    if (table_.channel(id).style == ChannelStyle::expression) return values;
    // The first splat into a row replaces the miss value, which can be infinite.
    if (state == RowState::splatted && table_.row_state(id, row) == RowState::untouched && table_.fill_value(id) != 0)
        std::fill_n(values, components, 0.0);
    if (state == RowState::written || table_.row_state(id, row) == RowState::untouched)
        table_.set_row_state(id, row, state);
    return values;
}

bool DisplayServices::splat(ChannelId id, int row, float value) {
    if (id == invalid_channel) return true;
    if (!accept(id, row, takes(id, ChannelType::real), true)) return false;
    if (!std::isfinite(value)) return refuse_value(id, row, Rgb(value));
    *entry(id, row, RowState::splatted) += static_cast<double>(value);
    return true;
}

bool DisplayServices::splat(ChannelId id, int row, const Rgb& value) {
    if (id == invalid_channel) return true;
    if (!accept(id, row, takes_triples(id), true)) return false;
    if (!is_finite(value)) return refuse_value(id, row, value);
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
    if (id == invalid_channel) return true;
    if (!accept(id, row, takes(id, ChannelType::real), true)) return false;
    if (!std::isfinite(value)) return refuse_value(id, row, Rgb(value));
    *entry(id, row, RowState::written) = static_cast<double>(value);
    return true;
}

bool DisplayServices::write(ChannelId id, int row, const Rgb& value) {
    if (id == invalid_channel) return true;
    if (!accept(id, row, takes_triples(id), true)) return false;
    if (!is_finite(value)) return refuse_value(id, row, value);
    double* values = entry(id, row, RowState::written);
    for (int c = 0; c < 3; ++c) values[c] = static_cast<double>(value[c]);
    return true;
}

bool DisplayServices::write(ChannelId id, int row, std::int32_t value) {
    if (id == invalid_channel) return true;
    if (!accept(id, row, takes(id, ChannelType::integer), true)) return false;
    *entry(id, row, RowState::written) = static_cast<double>(value);
    return true;
}

/// Checks the channel once, and each row and value.
template <class Value>
bool DisplayServices::write_batch(ChannelId id, std::span<const std::int32_t> rows, std::span<const Value> values,
                                  bool right_type) {
    if (id == invalid_channel) return true;
    const std::size_t count = std::min(rows.size(), values.size());
    if (!right_type)
        return refuse(
            id, known(id) && takes_samples(table_.channel(id)) ? Refusal::wrong_type : Refusal::unknown_channel, count);
    if (count == 0) return true;
    double* const to = table_.raw_values(id);
    const auto row_count = static_cast<std::uint32_t>(table_.row_count());
    const bool plain = table_.channel(id).style != ChannelStyle::expression;
    table_.touch(id);
    if (consecutive(rows.first(count), row_count)) {
        const auto first = static_cast<std::size_t>(rows.front());
        constexpr std::size_t components = std::is_same_v<Value, Rgb> ? 3 : 1;
        if (write_all(values.first(count), to + components * first)) [[likely]] {
            if (plain) table_.set_row_states(id, rows.front(), static_cast<int>(count), RowState::written);
            return true;
        }
    }
    std::uint64_t bad_rows = 0, bad_values = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::size_t>(static_cast<std::uint32_t>(rows[i]));
        const Value& value = values[i];
        if (row >= row_count) {
            ++bad_rows;
            continue;
        }
        bool finite = true;
        if constexpr (std::is_same_v<Value, Rgb>) finite = is_finite(value);
        else if constexpr (std::is_same_v<Value, float>) finite = std::isfinite(value);
        if (!finite) [[unlikely]] {
            ++bad_values;
            if constexpr (!std::is_same_v<Value, std::int32_t>) table_.count_invalid(rows[i], id, Rgb(value));
            continue;
        }
        if constexpr (std::is_same_v<Value, Rgb>)
            for (std::size_t c = 0; c < 3; ++c) to[3 * row + c] = static_cast<double>(value[static_cast<int>(c)]);
        else to[row] = static_cast<double>(value);
        if (plain) table_.set_row_state(id, static_cast<int>(row), RowState::written);
    }
    refuse(id, Refusal::unknown_row, bad_rows);
    refuse(id, Refusal::bad_value, bad_values);
    return bad_rows + bad_values == 0;
}

/// Writes whole columns if all are valid; otherwise write_batch() finds the invalid ones chunk by chunk.
bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, const Columns& columns) {
    if (rows.empty() || id == invalid_channel) return true;
    if (takes_triples(id) && consecutive(rows, static_cast<std::uint32_t>(table_.row_count()))) {
        const auto first = static_cast<std::size_t>(rows.front());
        if (write_all(columns, rows.size(), table_.raw_values(id) + 3 * first)) [[likely]] {
            table_.touch(id);
            if (table_.channel(id).style != ChannelStyle::expression)
                table_.set_row_states(id, rows.front(), static_cast<int>(rows.size()), RowState::written);
            return true;
        }
    }
    bool all = true;
    std::array<Rgb, 64> values;
    for (std::size_t first = 0; first < rows.size(); first += values.size()) {
        const std::size_t count = std::min(values.size(), rows.size() - first);
        for (std::size_t i = 0; i < count; ++i)
            values[i] = Rgb(columns[0][first + i], columns[1][first + i], columns[2][first + i]);
        all &= write(id, rows.subspan(first, count), std::span<const Rgb>(values.data(), count));
    }
    return all;
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const float> values) {
    return write_batch(id, rows, values, takes(id, ChannelType::real));
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const Rgb> values) {
    return write_batch(id, rows, values, takes_triples(id));
}

bool DisplayServices::write(ChannelId id, std::span<const std::int32_t> rows, std::span<const std::int32_t> values) {
    return write_batch(id, rows, values, takes(id, ChannelType::integer));
}

bool DisplayServices::write_distance(int row, float distance, bool is_volume) {
    if (!accept_row(row, true)) return false;
    if (std::isnan(distance)) return refuse_row_value(row, Rgb(distance));
    report(row);
    table_.depth[static_cast<std::size_t>(row)] = distance;
    table_.is_volume[static_cast<std::size_t>(row)] = is_volume ? 1 : 0;
    return true;
}

bool DisplayServices::write_opacity(int row, const Rgb& opacity) {
    if (!accept_row(row, true)) return false;
    if (!is_finite(opacity)) return refuse_row_value(row, opacity);
    report(row);
    table_.opacity[static_cast<std::size_t>(row)] = RgbD(opacity);
    return true;
}

bool DisplayServices::splat_opacity(int row, const Rgb& opacity) {
    if (!accept_row(row, true)) return false;
    if (!is_finite(opacity)) return refuse_row_value(row, opacity);
    report(row);
    table_.opacity[static_cast<std::size_t>(row)] += RgbD(opacity);
    return true;
}

bool DisplayServices::write_surface(int row, std::int32_t surface) {
    if (!accept_row(row, surface >= 0)) return false;
    report(row);
    table_.surface[static_cast<std::size_t>(row)] = surface;
    return true;
}

int DisplayServices::add_sample(int row, const ExtraSample& sample) {
    if (!accept_row(row, !std::isnan(sample.depth) && is_finite(sample.opacity) && sample.surface >= 0)) return -1;
    report(row);
    const int added = table_.add_row(row);
    if (added < 0) {
        refuse(invalid_channel, Refusal::no_room);
        const int last = table_.last_row_of(row);
        RgbD& opacity = table_.opacity[static_cast<std::size_t>(last)];
        for (int c = 0; c < 3; ++c) opacity[c] += (1 - opacity[c]) * sample.opacity[c];
        return last;
    }
    const auto index = static_cast<std::size_t>(added);
    table_.depth[index] = sample.depth;
    table_.opacity[index] = sample.opacity;
    table_.is_volume[index] = sample.is_volume ? 1 : 0;
    table_.surface[index] = sample.surface;
    return added;
}

bool DisplayServices::discard_iteration() {
    return table_.discard() || refuse(invalid_channel, Refusal::too_late);
}

}  // namespace raylex::display
