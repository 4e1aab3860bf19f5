// Reads rows of OpenEXR parts in their file layout: the values of a row are contiguous per channel, without per-sample
// copies. OpenEXR's C++ interface returns deep samples one by one, which took most of the time of a question to an
// atlas. This header includes no OpenEXR headers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::display {

class PackedRows {
  public:
    enum class Type : std::uint8_t { half, single, uint };
    struct Channel {
        std::string name;
        Type type = Type::single;
        [[nodiscard]] std::size_t bytes() const { return type == Type::half ? 2 : 4; }
    };

    /// One row of a part.
    class Row {
      public:
        /// [pixel + 1] The begin of each pixel's samples; in a flat part each pixel has one.
        [[nodiscard]] std::span<const std::uint32_t> begin() const { return begin_; }
        [[nodiscard]] std::size_t sample_count() const { return begin_.empty() ? 0 : begin_.back(); }
        /// `plane` is an index from PackedRows::plane() with the type Value; halves are std::uint16_t.
        template <class Value>
        [[nodiscard]] Value value(std::size_t plane, std::size_t sample) const {
            Value read;
            std::memcpy(&read, bytes_.data() + offset_[plane] + sample * sizeof(Value), sizeof(Value));
            return read;
        }

      private:
        friend class PackedRows;
        std::vector<std::uint32_t> begin_;
        std::vector<std::size_t> offset_;  // [plane]
        std::vector<std::byte> bytes_;
    };

    /// An open file, shared by all of its parts.
    class File;
    /// Opens a file that check_exr_file() accepted. Errors: it cannot be opened; it is damaged.
    static Result<std::shared_ptr<const File>> open_file(const std::string& path);
    /// Opens the part with the number `part`. Errors: no such part; several rows packed together, or unpacked deep
    /// rows; raylex writes neither.
    static Result<std::unique_ptr<PackedRows>> open(std::shared_ptr<const File> file, int part);
    ~PackedRows();

    /// The channels in the order of planes.
    [[nodiscard]] std::span<const Channel> channels() const;
    /// The index of a channel's plane; -1 if the part has none with this name and type.
    [[nodiscard]] int plane(const std::string& name, Type type) const;
    /// Reads row `y` of the part's data window. Several threads can call it at once. Errors: the row is truncated or
    /// damaged.
    Status read(int y, Row& row) const;

  private:
    struct Impl;
    explicit PackedRows(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace raylex::display
