// Writes numbers, texts and planes as the bytes of a record, in the byte order of this machine (little-endian; files
// declare it).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "display/buffer/fixed_point.h"

namespace raylex::display {

/// The width of the numbers of one page in a plane of sums: each is `width` bytes long, sign extended, times 2^(8 low).
struct PackedWidth {
    std::uint8_t low = 0, width = 16;
    /// Special width: the page equals that of the earlier plane it was compared with.
    static constexpr std::uint8_t same = 0xFF;

    static PackedWidth of(std::span<const Int128> values) {
        Int128 any = 0, spread = 0;
        for (const Int128 each : values) {
            any |= each;
            spread |= each ^ (each >> 127);  // the bits that differ from the sign
        }
        int low = 0, high = 16;
        while (low < 15 && ((any >> (8 * low)) & 0xFF) == 0) ++low;
        while (high > low + 1 && (spread >> (8 * (high - 1) - 1)) == 0) --high;
        return {static_cast<std::uint8_t>(low), static_cast<std::uint8_t>(high - low)};
    }
};

/// Appends values to `bytes`.
class RecordWriter {
  public:
    explicit RecordWriter(std::string& bytes) : bytes_(bytes) {}

    template <class Number>
    void number(Number value) {
        static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
        append(&value, sizeof value);
    }
    void text(std::string_view value) {
        number(static_cast<std::uint64_t>(value.size()));
        append(value.data(), value.size());
    }
    void numbers(std::span<const std::uint64_t> values) {
        number(static_cast<std::uint64_t>(values.size()));
        append(values.data(), values.size_bytes());
    }
    /// Writes a plane without its zero pages: the size, then (index, bytes) of every other page.
    void plane(std::span<const char> values) {
        number(static_cast<std::uint64_t>(values.size()));
        for (std::size_t at = 0; at < values.size(); at += page_size) {
            const std::size_t size = std::min(page_size, values.size() - at);
            if (all_zero(values.data() + at, size)) continue;
            number(static_cast<std::uint64_t>(at));
            append(values.data() + at, size);
        }
        number(end_of_plane);
    }

    /// Writes a plane of sums, which rarely need all 128 bits. Like plane(), but each page uses as few bytes per number
    /// as possible, and none if it equals the page of `like`, an earlier plane of the same size (empty: no comparison).
    void sums(std::span<const Int128> values, std::span<const Int128> like = {}) {
        constexpr std::size_t page = page_size / sizeof(Int128);
        number(static_cast<std::uint64_t>(values.size()));
        for (std::size_t at = 0; at < values.size(); at += page) {
            const std::span part = values.subspan(at, std::min(page, values.size() - at));
            if (all_zero(reinterpret_cast<const char*>(part.data()), part.size_bytes())) continue;
            number(static_cast<std::uint64_t>(at));
            if (!like.empty() && std::memcmp(part.data(), &like[at], part.size_bytes()) == 0) {
                number(PackedWidth::same);
                continue;
            }
            const PackedWidth packed = PackedWidth::of(part);
            number(packed.width);
            number(packed.low);
            char bytes[page_size + sizeof(Int128)];  // whole numbers are copied; each overwrites the excess of the one
                                                     // before
            for (std::size_t i = 0; i < part.size(); ++i) {
                const Int128 shifted = part[i] >> (8 * packed.low);
                std::memcpy(bytes + i * packed.width, &shifted, sizeof shifted);
            }
            append(bytes, part.size() * packed.width);
        }
        number(end_of_plane);
    }

    static constexpr std::size_t page_size = 4096;
    static constexpr std::uint64_t end_of_plane = ~std::uint64_t{0};

  private:
    void append(const void* data, std::size_t size) {
        if (size != 0) bytes_.append(static_cast<const char*>(data), size);
    }
    static bool all_zero(const char* data, std::size_t size) {
        // True if the first byte is 0 and every byte equals the one before it.
        return *data == 0 && std::memcmp(data, data + 1, size - 1) == 0;
    }
    std::string& bytes_;
};

/// Reads what RecordWriter wrote. After the first mismatch ok() is false, and all further values are 0 or empty.
class RecordReader {
  public:
    explicit RecordReader(std::string_view bytes) : left_(bytes) {}

    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] bool at_end() const { return ok_ && left_.empty(); }
    [[nodiscard]] std::string_view rest() const { return left_; }

    template <class Number>
    Number number() {
        static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
        Number value{};
        take(&value, sizeof value);
        return value;
    }
    std::string text() {
        const auto size = number<std::uint64_t>();
        if (size > left_.size()) fail();
        if (!ok_) return {};
        std::string value(left_.substr(0, size));
        left_.remove_prefix(size);
        return value;
    }
    std::vector<std::uint64_t> numbers() {
        const auto size = number<std::uint64_t>();
        if (size > left_.size() / sizeof(std::uint64_t)) fail();
        if (!ok_) return {};
        std::vector<std::uint64_t> values(size);
        take(values.data(), size * sizeof(std::uint64_t));
        return values;
    }
    /// Reads a plane into zeroed memory of exactly its size.
    void plane(std::span<char> values) {
        if (number<std::uint64_t>() != values.size()) fail();
        while (ok_) {
            const auto at = number<std::uint64_t>();
            if (at == RecordWriter::end_of_plane) return;
            if (at >= values.size() || at % RecordWriter::page_size != 0) return fail();
            take(values.data() + at, std::min<std::size_t>(RecordWriter::page_size, values.size() - at));
        }
    }
    /// Reads a plane that RecordWriter::sums() wrote.
    void sums(std::span<Int128> values, std::span<const Int128> like = {}) {
        constexpr std::size_t page = RecordWriter::page_size / sizeof(Int128);
        if (number<std::uint64_t>() != values.size()) fail();
        while (ok_) {
            const auto at = number<std::uint64_t>();
            if (at == RecordWriter::end_of_plane) return;
            if (at >= values.size() || at % page != 0) return fail();
            const std::span part = values.subspan(at, std::min(page, values.size() - at));
            PackedWidth packed;
            packed.width = number<std::uint8_t>();
            if (packed.width == PackedWidth::same) {
                if (like.size() != values.size()) return fail();
                std::copy_n(&like[at], part.size(), part.data());
                continue;
            }
            packed.low = number<std::uint8_t>();
            if (packed.width == 0 || packed.low + packed.width > 16 || left_.size() < part.size() * packed.width)
                return fail();
            const int empty = 8 * (16 - packed.width);
            for (std::size_t i = 0; i < part.size(); ++i) {
                UnsignedInt128 bits = 0;
                std::memcpy(&bits, left_.data() + i * packed.width, packed.width);
                part[i] = (static_cast<Int128>(bits << empty) >> empty) << (8 * packed.low);
            }
            left_.remove_prefix(part.size() * packed.width);
        }
    }
    void fail() {
        ok_ = false;
        left_ = {};
    }

  private:
    void take(void* data, std::size_t size) {
        if (size > left_.size()) return fail();
        if (size != 0) std::memcpy(data, left_.data(), size);
        left_.remove_prefix(size);
    }
    std::string_view left_;
    bool ok_ = true;
};

}  // namespace raylex::display
